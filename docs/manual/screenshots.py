"""The manual's pictures, from a real Blender: one command takes all of them anew.

    SPECTRAL_PROBE_WINDOW="COMMAND" .venv/bin/python docs/manual/screenshots.py

COMMAND runs a script in a Blender with a window, as tests/window/conftest.py says, and must let it run for ten minutes, on a slow
machine longer. The extension comes from the zip in dist/ (python3 run.py build), or from the user folder that
SPECTRAL_PROBE_WINDOW_PROFILE names, with this checkout's files. The gym of sample_scenes/ is imported, built, rendered and
compared as the manual tells it; pictures/ gets the pictures, cut below the last line drawn and reduced to few colours.
`--only-pack FOLDER` makes them from the screenshots of an earlier run, which `--keep FOLDER` kept.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from types import ModuleType

import numpy as np
from PIL import Image

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PICTURES = HERE / "pictures"
MOST_BYTES = 2_000_000
LIMIT_S = 1500
COLOURS = 128
_MARGIN_PX = 12
_ROWS_PX = {
    "import": (0, 420), "guide": (0, 400), "imported": (0, 620), "lit": (160, 800),
    "direction": (240, 740), "region": (240, 740), "glasses": (240, 740),
}  # fmt: skip
"""First and last row of pictures of which the rest shows nothing."""

_PHOTOGRAPHIC = frozenset({"lit", "sheet", "direction", "glasses", "region", "outline"})
"""These show photographs or renders: all the colours a palette can have."""


def main() -> int:
    """Take the pictures, or pack those of an earlier run."""
    parser = argparse.ArgumentParser(prog="screenshots.py", description=__doc__.splitlines()[0])
    parser.add_argument("--only-pack", type=Path, metavar="FOLDER", help="screenshots of an earlier run")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="where screenshots and log are kept")
    arguments = parser.parse_args()
    if arguments.only_pack is not None:
        return pack(arguments.only_pack)
    command = os.environ.get("SPECTRAL_PROBE_WINDOW", "")
    if not command:
        sys.stderr.write("SPECTRAL_PROBE_WINDOW names no command that opens a Blender window.\n")
        return 2
    with tempfile.TemporaryDirectory(prefix="manual_", ignore_cleanup_errors=True) as temporary:
        folder = arguments.keep.resolve() if arguments.keep else Path(temporary, "shots")
        folder.mkdir(parents=True, exist_ok=True)
        if not take(shlex.split(command), Path(temporary), folder):
            return 1
        return pack(folder)


def take(command: list[str], temporary: Path, folder: Path) -> bool:
    """Run Blender through the example; whether it came to its end."""
    window = _module(ROOT / "tests" / "window" / "conftest.py")
    profile = temporary / "resources"
    ready = os.environ.get("SPECTRAL_PROBE_WINDOW_PROFILE", "")
    if ready:
        window.linked_copy(Path(ready), profile)
        window.lay_checkout_over(ROOT, profile / window.EXTENSION_FOLDER)
    else:
        profile.mkdir()
        newest = max((ROOT / "dist").glob("*.zip"), key=lambda file: file.stat().st_mtime)
        window.run(command, "install", profile, ROOT, [newest])
    photographs = temporary / "gym"
    photographs.mkdir()
    sample = ROOT / "sample_scenes" / "gym"
    for file in [*sample.glob("*.dng"), sample / "capture.toml"]:
        shutil.copy(file, photographs)
    for old in (*folder.glob("*.png"), *folder.glob("result.json")):
        old.unlink()
    words = [HERE / "screenshot_steps.py", folder, photographs]
    environment = {**os.environ, "BLENDER_USER_RESOURCES": str(profile), "DISPLAY_SIZE": "1400x1000"}
    with (folder / "log.txt").open("w", encoding="utf-8") as log:
        subprocess.run(
            [*command, *map(str, words)],
            cwd=ROOT,
            env=environment,
            stdout=log,
            stderr=subprocess.STDOUT,
            timeout=LIMIT_S,
            check=False,
        )
    log_text = (folder / "log.txt").read_text("utf-8", errors="replace")
    result = folder / "result.json"
    error = json.loads(result.read_text("utf-8"))["error"] if result.is_file() else "Blender did not end."
    if error is None and "Traceback" in log_text:
        error = "There is a traceback in the log."
    if error is not None:
        sys.stderr.write(f"{error}\nPictures and log: {folder}\n{log_text[-3000:]}\n")
    return error is None


def pack(folder: Path) -> int:
    """Cut and reduce the screenshots of a folder into the manual's pictures."""
    PICTURES.mkdir(exist_ok=True)
    for old in PICTURES.glob("*.png"):
        old.unlink()
    for file in sorted(folder.glob("*.png")):
        if file.stem == "error":
            continue
        with Image.open(file) as opened:
            top, bottom = _ROWS_PX.get(file.stem, (0, opened.height))
            picture = cut(opened.convert("RGB").crop((0, top, opened.width, bottom)))
        photographic = file.stem in _PHOTOGRAPHIC
        picture.quantize(
            256 if photographic else COLOURS,
            dither=Image.Dither.FLOYDSTEINBERG if photographic else Image.Dither.NONE,
        ).save(PICTURES / file.name, optimize=True)
    size = sum(file.stat().st_size for file in PICTURES.glob("*.png"))
    sys.stdout.write(f"{len(list(PICTURES.glob('*.png')))} pictures, {size / 1e6:.2f} MB\n")
    return 0 if size < MOST_BYTES else 1


def cut(picture: Image.Image) -> Image.Image:
    """Without the empty rows below the last thing drawn, such as an editor's background."""
    pixels = np.asarray(picture).astype(np.int16)
    middle = pixels[:, pixels.shape[1] // 10 : -pixels.shape[1] // 20]
    spread = (middle.max(axis=1) - middle.min(axis=1)).max(axis=-1)
    drawn = np.flatnonzero(spread[:-_MARGIN_PX] > 24)
    end = min(int(drawn[-1]) + _MARGIN_PX, picture.height) if drawn.size else picture.height
    return picture.crop((0, 0, picture.width, end))


def _module(path: Path) -> ModuleType:
    specification = importlib.util.spec_from_file_location(path.stem, path)
    module = sys.modules[path.stem] = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


if __name__ == "__main__":
    sys.exit(main())
