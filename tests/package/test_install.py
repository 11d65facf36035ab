"""The zip installs in Blender, registers, brings its libraries along, and leaves nothing behind."""

import importlib.metadata
import json
import os
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import Any

import pytest


def packages_of_blender_only(builder, folder: Path) -> Path:
    """A folder of links to the installed packages without those that the zip must bring."""
    bundled = set()
    for name in builder.bundled_packages():
        files = importlib.metadata.files(name)
        assert files is not None
        bundled |= {file.parts[0] for file in files}
    installed = Path(sysconfig.get_path("platlib"))
    folder.mkdir()
    for entry in installed.iterdir():
        if entry.name not in bundled and entry.suffix != ".pth":
            (folder / entry.name).symlink_to(entry)
    return folder


@pytest.fixture(scope="module")
def report(extension_zip, builder, tmp_path_factory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("blender")
    packages = packages_of_blender_only(builder, folder / "packages")
    answer = subprocess.run(
        [
            sys.executable,
            "-S",
            Path(__file__).with_name("installed.py"),
            extension_zip,
            folder / "report.json",
        ],
        cwd=folder,
        env={
            "PATH": os.environ["PATH"],
            "HOME": str(folder),
            "BLENDER_USER_RESOURCES": str(folder / "resources"),
            "PYTHONPATH": str(packages),
        },
        capture_output=True,
        text=True,
        check=False,
    )
    output = answer.stdout + answer.stderr
    assert answer.returncode == 0, output
    assert "Traceback" not in output, output
    return json.loads((folder / "report.json").read_text("utf-8"))


def test_it_is_enabled_and_has_its_settings_operators_and_panels(report):
    assert report["settings"] == ["Material", "Scene"]
    kinds = {name.split("_")[2] for name in report["registered"]}
    assert {"OT", "PT"} <= kinds


def test_the_core_runs_on_the_libraries_of_the_zip(report):
    assert "spectral_probe.model" in report["modules"]
    assert report["not_from_the_zip"] == []


def test_enabling_it_loads_no_heavy_library(report):
    assert report["loaded_at_start"] == []


def test_disabling_it_leaves_nothing_behind(report):
    assert report["left_behind"] == []
    assert report["settings_left_behind"] == []
