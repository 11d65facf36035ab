"""A Blender with a window, the extension installed in it from the zip, driven by scenarios (see driver.py).

These tests run where SPECTRAL_PROBE_WINDOW names a command that runs a script in a Blender with a window:

    SPECTRAL_PROBE_WINDOW="COMMAND" .venv/bin/python -m pytest tests/window

Blender is started as `COMMAND SCRIPT WORDS...`, with --enable-event-simulate, WORDS after `--`, BLENDER_USER_RESOURCES and
DISPLAY_SIZE passed on. The zip (python3 run.py build) is installed once. To try a change without building it, name the user
folder of a Blender that has the extension already; the files of this checkout are laid over a copy of it:

    SPECTRAL_PROBE_WINDOW_PROFILE=FOLDER

A test is a function over a scenario's outcome:

    def test_the_capture_is_imported(scenario):
        outcome = scenario("import_capture", sample / "capture.toml")
        assert outcome.results["views"] == 3

which has started Blender on a copy of the profile, run scenarios/import_capture.py, and failed where it raised, where
Blender did not end by itself, or where the log has a traceback. Pictures and log stay in test-pictures/window/NAME/.
"""

from __future__ import annotations

import json
import os
import shlex
import shutil
import signal
import subprocess
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

collect_ignore = ["driver.py", "scenarios"]  # they run in Blender

HERE = Path(__file__).resolve().parent
EXTENSION_FOLDER = Path("extensions", "user_default", "spectral_probe")
PRODUCT_FOLDERS = (
    *(
        "operators",
        "panels",
        "settings",
        "spectral_probe",
        "sample_scenes",
        "assets",
        "presets",
        "translations",
    ),
)
LIMIT_S = 295
SIGNS_OF_A_DEFECT = ("Traceback (most recent call last)", "Python script error in", "Segmentation fault")


@dataclass(frozen=True)
class Outcome:
    """What a scenario left."""

    folder: Path
    log: str
    seconds: dict[str, float]
    freezes_s: dict[str, float]
    results: dict[str, Any]
    reports: list[str]


type Scenario = Callable[..., Outcome]


@pytest.fixture(scope="session")
def window_command() -> list[str]:
    """The command that runs a script in a Blender with a window."""
    command = os.environ.get("SPECTRAL_PROBE_WINDOW", "")
    if not command:
        pytest.skip("no Blender with a window here: SPECTRAL_PROBE_WINDOW names none")
    return shlex.split(command)


@pytest.fixture(scope="session")
def profile(
    window_command: list[str],
    project_root: Path,
    tmp_path_factory: pytest.TempPathFactory,
    request: pytest.FixtureRequest,
) -> Iterator[Path]:
    """A user folder of Blender with the extension in it, installed from the zip into a clean one."""
    folder = tmp_path_factory.mktemp("profile") / "resources"
    ready = os.environ.get("SPECTRAL_PROBE_WINDOW_PROFILE", "")
    if ready:
        linked_copy(Path(ready), folder)
        lay_checkout_over(project_root, folder / EXTENSION_FOLDER)
    else:
        folder.mkdir()
        run(window_command, "install", folder, project_root, [request.getfixturevalue("extension_zip")])
    yield folder
    shutil.rmtree(folder)  # half a gigabyte, which pytest would keep for three sessions


@pytest.fixture
def scenario(window_command: list[str], profile: Path, project_root: Path, tmp_path: Path) -> Scenario:
    """Run a scenario by name, with further words, on its own copy of the profile."""

    def play(name: str, *words: object) -> Outcome:
        own = tmp_path / f"resources_{name}"
        linked_copy(profile, own)
        try:
            return run(window_command, name, own, project_root, list(words))
        finally:
            shutil.rmtree(own)

    return play


@pytest.fixture
def clean_scenario(window_command: list[str], project_root: Path, tmp_path: Path) -> Scenario:
    """Run a scenario in a Blender that was never started before."""

    def play(name: str, *words: object) -> Outcome:
        own = tmp_path / f"clean_{name}"
        own.mkdir()
        try:
            return run(window_command, name, own, project_root, list(words))
        finally:
            shutil.rmtree(own)

    return play


def run(command: list[str], name: str, resources: Path, project_root: Path, words: list[object]) -> Outcome:
    """Start Blender, have it play the scenario, and fail where anything went wrong."""
    folder = project_root / "test-pictures" / "window" / name
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    script = [HERE / "driver.py", HERE / "scenarios" / f"{name}.py", folder, *words]
    environment = {**os.environ, "BLENDER_USER_RESOURCES": str(resources)}
    environment.setdefault("DISPLAY_SIZE", "1280x800")
    with (folder / "log.txt").open("w", encoding="utf-8") as log:
        process = subprocess.Popen(
            [*command, *map(str, script)],
            cwd=project_root,
            env=environment,
            stdout=log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            status = process.wait(LIMIT_S)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGTERM)
            process.wait()
            status = None
    return judged(folder, status)


def judged(folder: Path, status: int | None) -> Outcome:
    """The outcome of a scenario; where it failed, the test fails with what is known."""
    log = (folder / "log.txt").read_text("utf-8", errors="replace")
    result_file = folder / "result.json"
    if not result_file.is_file():
        how = f"did not end in {LIMIT_S} s" if status is None else f"ended with {status}"
        pytest.fail(f"Blender {how} before the scenario did. Log, {folder}:\n{log[-4000:]}")
    result = json.loads(result_file.read_text("utf-8"))
    error = result.pop("error")
    if error is not None:
        pytest.fail(f"The scenario failed, pictures and log in {folder}:\n{error}\n{log[-3000:]}")
    defects = [sign for sign in SIGNS_OF_A_DEFECT if sign in log]
    if defects or status != 0:
        pytest.fail(f"Blender ended with {status}; its log, {folder}:\n{log[-6000:]}")
    return Outcome(folder=folder, log=log, **result)


def linked_copy(source: Path, target: Path) -> None:
    """A copy of a user folder: what Blender writes to is copied, the libraries, half a gigabyte, are linked."""
    libraries = (source / "extensions" / ".local", source / EXTENSION_FOLDER / "wheels")

    def link_or_copy(old: str, new: str) -> None:
        if any(Path(old).is_relative_to(folder) for folder in libraries):
            try:
                os.link(old, new)
            except OSError:  # on another disk
                pass
            else:
                return
        shutil.copy2(old, new)

    shutil.copytree(source, target, copy_function=link_or_copy, symlinks=True)


def lay_checkout_over(project_root: Path, extension: Path) -> None:
    """Replace the code and data of an installed extension by the checkout's.

    Manifest and wheels stay as they are: by the manifest's time Blender knows whether to look for wheels anew, and it
    removes the libraries whose wheels are gone.
    """
    for entry in extension.iterdir():
        if entry.is_dir() and entry.name != "wheels":
            shutil.rmtree(entry)
        elif entry.suffix == ".py":
            entry.unlink()
    for file in project_root.glob("*.py"):
        shutil.copy2(file, extension / file.name)
    for name in PRODUCT_FOLDERS:
        if (project_root / name).is_dir():
            ignored = shutil.ignore_patterns("__pycache__")
            shutil.copytree(project_root / name, extension / name, ignore=ignored)
