"""The manual names every panel and operator; its reference is what Blender knows now; its links and pictures are there.

That it names every verb of the command line is looked at in tests/core/test_cli.py.
"""

import importlib.util
import re
import subprocess
import sys

import pytest

LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ (.+)$", re.MULTILINE)
SELF_EVIDENT = {
    "Add Region", "Add Measured Lamp", "Remove Measured Lamp", "Remove Region", "Make Region Swappable", "Not Swappable",
    "Add View", "Remove View", "Add Photographs to View", "Remove Photograph", "Move Photograph", "Join Views", "Remove",
    "Spread Views Evenly", "Copy Report", "Choose Spectrum", "Edit Outline", "Import Capture", "Save Capture", "New Mask",
    "Load Spectral Probe Preset", "Save Spectral Probe Preset", "Add Metal Object", "Make Spectral Probe Paths", "Lay Ground",
    "Match Plate", "Show Comparison",
}  # fmt: skip
"""Operators behind buttons of another name, or explained on a page elsewhere: the reference has them."""


@pytest.fixture(scope="module")
def manual(project_root):
    return project_root / "docs" / "manual"


@pytest.fixture(scope="module")
def reference(manual):
    specification = importlib.util.spec_from_file_location("manual_reference", manual / "reference.py")
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def test_the_reference_is_what_blender_knows(manual, reference):
    told = "reference.md is old. Write it anew: .venv/bin/python docs/manual/reference.py"
    assert reference.reference() == (manual / "reference.md").read_text("utf-8"), told


def test_every_panel_is_in_the_page_on_panels(manual, reference):
    page = (manual / "panels.md").read_text("utf-8")
    labels = {panel.bl_label for panel in reference.panels()}
    assert len(labels) > 15
    assert [label for label in sorted(labels) if label not in page] == []


def test_every_operator_is_in_the_reference(manual, reference):
    page = (manual / "reference.md").read_text("utf-8")
    verbs = [reference.verb_of(operator) for operator in reference.operators()]
    assert len(verbs) > 50
    assert [verb for verb in verbs if f"`{verb}`" not in page] == []


def test_buttons_of_jobs_are_explained(manual, reference):
    pages = "\n".join(
        (manual / name).read_text("utf-8") for name in ("panels.md", "first_render.md", "install.md")
    )
    pages = " ".join(pages.split())
    names = {operator.name for operator in reference.operators()} - SELF_EVIDENT
    assert [name for name in sorted(names) if f"**{name}**" not in pages] == []


def pages(project_root):
    return [project_root / "README.md", *sorted((project_root / "docs").rglob("*.md"))]


def anchor(heading):
    """What a heading is linked by, as GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


def test_every_link_leads_somewhere(project_root):
    broken = []
    for page in pages(project_root):
        for target in LINK.findall(page.read_text("utf-8")):
            if "://" in target:
                continue
            path, _, part = target.partition("#")
            file = (page.parent / path).resolve() if path else page
            headings = HEADING.findall(file.read_text("utf-8")) if part and file.is_file() else []
            if not file.exists() or (part and part not in map(anchor, headings)):
                broken.append(f"{page.name}: {target}")
    assert broken == []


def test_pictures_are_small_and_all_of_them_are_shown(manual):
    pictures = sorted((manual / "pictures").iterdir())
    text = "\n".join(page.read_text("utf-8") for page in manual.glob("*.md"))
    assert [file.name for file in pictures if f"pictures/{file.name}" not in text] == []
    assert sum(file.stat().st_size for file in pictures) < 2_000_000


def test_the_screenshots_say_what_they_need(manual, project_root):
    answer = subprocess.run(
        [sys.executable, manual / "screenshots.py"],
        cwd=project_root,
        env={},
        capture_output=True,
        text=True,
        check=False,
    )
    assert answer.returncode == 2
    assert "SPECTRAL_PROBE_WINDOW" in answer.stderr
