"""Coverage-guided fuzzing (atheris, libFuzzer) of the parsers that are our own, one target at a time:

    .venv/bin/python tests/faults/fuzz.py capture -max_total_time=60
    .venv/bin/python tests/faults/fuzz.py --all 60          ten minutes: every target, that many seconds each

An input may be read, or refused with a SpectralProbeError; anything else is a finding, which libFuzzer keeps as crash-... in
the folder given by -artifact_prefix. What was found and put right is among the tests as an input of its own.
"""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

import atheris  # noqa: E402  # after the path: what it imports is instrumented

with atheris.instrument_imports(include=["spectral_probe"]):
    from spectral_probe.cli_render import frame_list
    from spectral_probe.errors import SpectralProbeError
    from spectral_probe.files.capture import load_capture
    from spectral_probe.files.cryptomatte import number_of, object_shares
    from spectral_probe.files.exr_limits import check_exr
    from spectral_probe.files.preset_file import read_preset
    from spectral_probe.files.region_json import read_region
    from spectral_probe.files.spectral_channels import find_channels, spectrum_of_text
    from spectral_probe.files.spectrum_file import read_samples
    from spectral_probe.photo.exif import lens_and_exposure
    from spectral_probe.photo.file_kind import file_kind, jpeg_size, png_header
    from spectral_probe.photo.profile import read_profile
    from spectral_probe.photo.tiff import check_tiff, exif_of_tiff
    from spectral_probe.render.pass_folder import open_pass_folder
    from spectral_probe.render.plan_file import load_plan
    from spectral_probe.spectra.curves import LIGHT, on_grid
    from spectral_probe.spectra.white import parse_white
    from spectral_probe.swapping import read_swaps

type Target = Callable[[Path, bytes], object]

# In memory where the system has a place for that: the fuzzer writes a thousand files a second.
FOLDER = Path(tempfile.mkdtemp(prefix="fuzz-", dir="/dev/shm" if Path("/dev/shm").is_dir() else None))  # noqa: S108


def written(folder: Path, name: str, data: bytes) -> Path:
    """The input as a file."""
    path = folder / name
    path.write_bytes(data)
    return path


def spectrum(suffix: str) -> Target:
    """A file with a spectrum, onto the exchange grid."""
    return lambda folder, data: on_grid(read_samples(written(folder, f"a{suffix}", data)), LIGHT)


def tiff(folder: Path, data: bytes) -> None:
    """The directories and the EXIF tags of a file built as TIFF."""
    path = written(folder, "a.tif", b"II*\0" + data if data[:1] < b"\x80" else b"MM\0*" + data)
    lens_and_exposure(exif_of_tiff(path))
    check_tiff(path)


def headers(folder: Path, data: bytes) -> None:
    """The headers of photographs of any kind."""
    for name, start in (("a.jpg", b"\xff\xd8\xff"), ("a.png", b"\x89PNG\r\n\x1a\n")):
        path = written(folder, name, start + data)
        file_kind(path)
        with contextlib.suppress(SpectralProbeError):
            (jpeg_size if name == "a.jpg" else png_header)(path)


def words(_folder: Path, data: bytes) -> None:
    """Words of the command line and of headers: white, frames, channels, spectra as text, names of objects."""
    import argparse

    text = data.decode("utf-8", "surrogateescape")
    for parse in (
        parse_white,
        frame_list,
        spectrum_of_text,
        lambda one: find_channels(one.split("\n"), "a.exr"),
    ):
        with contextlib.suppress(SpectralProbeError, argparse.ArgumentTypeError):
            parse(text)
    number_of(data.decode("utf-8", "replace"))


def matte(_folder: Path, data: bytes) -> None:
    """Channels of a cryptomatte by any names."""
    import numpy as np

    names = data.decode("latin-1").split("\n")
    object_shares({f"CryptoObject{name}": np.zeros((2, 2), np.float32) for name in names}, ["Cube"])


def profile(_folder: Path, data: bytes) -> None:
    """An ICC profile."""
    read_profile(data)


TARGETS: dict[str, Target] = {
    "capture": lambda folder, data: load_capture(written(folder, "a.toml", data)),
    "preset": lambda folder, data: read_preset(written(folder, "a.toml", data)),
    "region": lambda folder, data: read_region(written(folder, "a.json", data)),
    "plan": lambda folder, data: load_plan(written(folder, "plan.json", data)),
    "manifest": lambda folder, data: open_pass_folder(written(folder, "index.json", data).parent),
    "swaps": lambda folder, data: read_swaps(written(folder, "swaps.json", data).parent),
    "table": spectrum(".csv"),
    "tm27": spectrum(".spdx"),
    "ampas": spectrum(".json"),
    "exr": lambda folder, data: check_exr(written(folder, "a.exr", b"v/1\x01" + data)),
    "tiff": tiff,
    "headers": headers,
    "profile": profile,
    "words": words,
    "matte": matte,
}


def seeds(target: str, folder: Path) -> None:
    """A corpus of sound inputs to begin with."""
    from tests.faults import seeds as made

    rows = made.ROWS.encode()
    texts: dict[str, Sequence[bytes]] = {
        "capture": [made.CAPTURE.encode()],
        "preset": [b'ball_radius = 0.05\n[camera]\nmodel = "Nikon"\nlist = [1, [2]]\n'],
        "region": [json.dumps(made.REGION).encode(), b'{"seed_deg": [1, 2]}', b'{"mask": "a.png"}'],
        "table": [
            rows,
            rows.replace(b",", b"\t"),
            rows.replace(b".", b",").replace(b",", b";", 1),
            made.CGATS.encode(),
        ],
        "tm27": [made.TM27.encode()],
        "ampas": [json.dumps(made.AMPAS).encode()],
        "words": [
            b"5000 K",
            b"0.31,0.33",
            b"1-3,10,2",
            b"S0.400,0nm\nT.5E2nm\nwavelength430_25",
            b"400.0nm:0.5;0.7um:1",
        ],
        "matte": [b"00.r\n00.g\n00.b\n00.a"],
    }
    for number, text in enumerate(texts.get(target, ())):
        (folder / f"{number}").write_bytes(text)
    sources = {"plan": "plan.json", "swaps": "swaps.json"}
    if target in sources:
        made.swappable(folder)
        for path in folder.iterdir():
            if path.name != sources[target]:
                path.unlink()
    if target == "manifest":
        made.composed(folder / "made")
        (folder / "0").write_bytes((folder / "made/render/passes/index.json").read_bytes())
    if target in ("exr", "tiff", "headers"):
        pictures = {
            "exr": ("a.exr", "parts.exr"),
            "tiff": ("a.dng", "eight.tif"),
            "headers": ("a.jpg", "a.png"),
        }[target]
        for name in pictures:
            (folder / "made").mkdir(exist_ok=True)
            made.boards(name)(folder / "made")
            (folder / name).write_bytes(
                (folder / "made" / name).read_bytes()[8 if name == "a.png" else 4 : 6000]
            )
    if target == "profile":
        from PIL import ImageCms

        (folder / "0").write_bytes(ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes())


def run_all(seconds: int) -> int:
    """Every target in a process of its own; how many found something."""
    failed = 0
    for name in TARGETS:
        words = [
            sys.executable,
            __file__,
            name,
            f"-max_total_time={seconds}",
            "-timeout=10",
            "-rss_limit_mb=4096",
        ]
        ended = subprocess.run([*words, "-print_final_stats=1"], capture_output=True, text=True, check=False)
        lines = [line for line in ended.stderr.splitlines() if "cov:" in line or "number_of_executed" in line]
        sys.stdout.write(
            f"{name}: {'found something' if ended.returncode else 'nothing found'}; {' | '.join(lines[-2:])}\n"
        )
        if ended.returncode:
            failed += 1
            sys.stdout.write(ended.stderr[-3000:] + "\n")
        sys.stdout.flush()
    return failed


def main() -> None:
    """Fuzz one target with libFuzzer's own words, or all of them."""
    if sys.argv[1] == "--all":
        sys.exit(run_all(int(sys.argv[2])))
    target, corpus = TARGETS[sys.argv[1]], FOLDER / "corpus"
    corpus.mkdir()
    seeds(sys.argv[1], corpus)
    warnings.simplefilter("error")

    def once(data: bytes) -> None:
        with contextlib.suppress(SpectralProbeError):
            target(FOLDER, data)

    atheris.Setup([sys.argv[0], *sys.argv[2:], f"-artifact_prefix={FOLDER}/", str(corpus)], once)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
