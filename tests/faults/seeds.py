"""Sound inputs of every format that is read, small, and the words that read them: a folder a kind, one file of it is mutated."""

from __future__ import annotations

import importlib.util
import json
import shutil
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import cv2
import numpy as np
import OpenEXR
from PIL import Image

TESTS = Path(__file__).resolve().parents[1]
OUT = ("-o", "out")


@dataclass(frozen=True)
class Kind:
    """A format, in one of the places where it is read.

    `make` fills the kind's folder, `target` is the file in it that is mutated, `words` are run in it.
    """

    make: Callable[[Path], None]
    target: str
    words: tuple[str, ...]


def script(name: str) -> ModuleType:
    """A test module with helpers that are used here too."""
    path = TESTS / name
    spec = importlib.util.spec_from_file_location(f"seeds_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


# ---------------------------------------------------------------- photographs


def room() -> Any:
    """A simulated room with two lamps."""
    from spectral_probe.spectra.colorimetry import illuminant

    lamps = {
        "A": (-70.0, 25.0, 8.0, 30.0, illuminant("A")),
        "D65": (110.0, 0.0, 12.0, 25.0, illuminant("D65")),
    }
    return script("core/conftest.py").SimulatedRoom(lamps=lamps)


CAPTURE = """# all that a capture file may say
[camera]
model = "Nikon 5100 (NPL)"
focal_px = 1350.0
principal_px = [100.0, 100.0]
distortion = [0, 0, 0, 0, 0]

[ball]
radius_m = 0.05
material = "SUS304"

[light]
families = ["incandescent", "daylight"]

[panorama]
composition = "blend"

[[view]]
azimuth_deg = 0
elevation_deg = 5.0
refine = false
photos = ["view.exr"]
exposures_s = [1.0]
iso = [100]
f_number = [1.0]
outline = [100.0, 100.0, 84.5]

[[region]]
seed_deg = [200, 0]
families = ["daylight"]
"""


def capture_with(**words: str) -> str:
    """The capture file with some lines replaced: by the name of their key."""
    lines = []
    for line in CAPTURE.splitlines():
        key = line.partition(" =")[0]
        lines.append(words.pop(key, line))
    return "\n".join([*lines, *words.values()]) + "\n"


def ball_picture(suffix: str) -> Callable[[Path], None]:
    """A capture whose one photograph is of a kind."""

    def make(folder: Path) -> None:
        picture = room().photograph()
        name, lines = f"view{suffix}", {}
        write_picture(folder / name, picture)
        lines["photos"] = f'photos = ["{name}"]'
        if suffix in (".jpg", ".png"):
            lines["model"] = ""
        (folder / "capture.toml").write_text(capture_with(**lines))

    return make


def write_picture(path: Path, linear: np.ndarray) -> None:
    """Linear camera RGB (H, W, 3) in a file of the kind that its name says."""
    level = np.clip(linear / (1.2 * float(np.percentile(linear, 99))), 0, 1)
    match path.suffix:
        case ".exr":
            header = {"compression": OpenEXR.PIZ_COMPRESSION}
            planes = {
                name: np.ascontiguousarray(linear[..., at], np.float16) for at, name in enumerate("RGB")
            }
            OpenEXR.File(header, planes).write(str(path))
        case ".hdr":
            cv2.imwrite(str(path), np.ascontiguousarray(linear[..., ::-1], np.float32))
        case ".jpg":
            image = Image.fromarray((255 * level ** (1 / 2.2)).astype(np.uint8))
            exif = Image.Exif()
            exif[0x829A], exif[0x8827], exif[0x0112] = 0.01, 200, 1
            image.save(path, exif=exif, quality=90)
        case ".png":
            Image.fromarray((255 * level ** (1 / 2.2)).astype(np.uint8)).save(path)
        case ".tif":
            cv2.imwrite(str(path), np.ascontiguousarray((65000 * level[..., ::-1]).astype(np.uint16)))
        case _:
            mosaic = 512 + 15000 * np.where(
                (np.indices(level.shape[:2]).sum(0) % 2)[..., None] == 1, level[..., 1:2], level[..., :1]
            )
            mosaic[1::2, 1::2] = 512 + 15000 * level[1::2, 1::2, 2:]
            script("core/photo/test_read_bad_input.py").write_dng(path, mosaic[..., 0])


def boards(name: str) -> Callable[[Path], None]:
    """Four photographs for the calibration of a camera, one of them of a kind."""

    def make(folder: Path) -> None:
        linear = (
            np.kron(np.indices((6, 8)).sum(0) % 2, np.ones((12, 12)))[..., None] * np.ones(3, np.float32)
            + 0.1
        )
        for number in range(3):
            write_picture(folder / f"b{number}.png", linear)
        path = folder / name
        if name == "deep.png":
            cv2.imwrite(str(path), (30000 * linear).astype(np.uint16))
        elif name == "float.tif":
            cv2.imwrite(str(path), linear.astype(np.float32))
        elif name == "eight.tif":
            Image.fromarray((200 * linear / linear.max()).astype(np.uint8)).save(path, compression="tiff_lzw")
        elif name == "parts.exr":
            planes = {letter: np.ascontiguousarray(linear[..., 0], np.float32) for letter in "RGB"}
            tiled = {"type": OpenEXR.tiledimage, "tiles": OpenEXR.TileDescription(), "name": "beauty"}
            OpenEXR.File(
                [OpenEXR.Part(tiled, dict(planes)), OpenEXR.Part({"name": "z"}, {"Z": planes["R"]})]
            ).write(str(path))
        else:
            write_picture(path, linear)

    return make


def calibrate(name: str) -> Kind:
    """A photograph read by `calibrate`."""
    words = ("calibrate", name, "b0.png", "b1.png", "b2.png", "-o", "out/camera.json")
    return Kind(boards(name), name, (*words, "--board", "chessboard", "--columns", "8", "--rows", "6"))


# ---------------------------------------------------------------- probes, regions, spectra

REGION = {"polygon_deg": [[0, -10], [60, -10], [60, 50], [0, 50]]}
ROWS = "".join(f"{nm},{0.2 + 0.001 * (nm - 380):.4f}\n" for nm in range(380, 721, 10))
TM27 = (
    '<?xml version="1.0" encoding="utf-8"?><IESTM2714 xmlns="iestm2714" version="1.0"><Header><Manufacturer>Acme</Manufacturer>'
    "</Header><SpectralDistribution><SpectralQuantity>relative</SpectralQuantity>"
    + "".join(f'<SpectralData wavelength="{nm}">{nm / 1000}</SpectralData>' for nm in range(380, 721, 10))
    + "</SpectralDistribution></IESTM2714>"
)
AMPAS = {
    "header": {"license": "Apache-2.0", "laboratory": "Acme"},
    "spectral_data": {
        "index": {"main": ["R", "G", "B"]},
        "data": {
            "main": {
                str(nm): [2.0 ** -(((nm - c) / 40) ** 2) for c in (600, 540, 460)]
                for nm in range(380, 721, 10)
            }
        },
    },
}
BANDS = range(380, 731, 10)
CGATS = (
    "CGATS.17\nBEGIN_DATA_FORMAT\nSAMPLE_ID SAMPLE_NAME "
    + " ".join(f"nm{nm}" for nm in BANDS)
    + "\nEND_DATA_FORMAT\n"
    'BEGIN_DATA\n1 "card" ' + " ".join(f"{nm / 1000}" for nm in BANDS) + "\nEND_DATA\n"
)


def probe(path: Path) -> None:
    """A recovered panorama with an edit."""
    from spectral_probe.files.probe_exr import write_probe
    from spectral_probe.model import Edit, SpectralPanorama
    from spectral_probe.spectra.camera import camera_sensitivities
    from spectral_probe.spectra.grid import WAVELENGTHS_NM
    from spectral_probe.spectra.recorded import ENTRY, record
    from spectral_probe.spectra.recovery import spectral_recovery

    recovery = spectral_recovery(camera_sensitivities("Nikon 5100 (NPL)"), ["daylight"], "paper")
    shape = (16, 32)
    weights = np.random.default_rng(5).uniform(0.5, 1.0, (*shape, 3)).astype(np.float32)
    panorama = SpectralPanorama(
        weights=weights,
        bases=np.concatenate([recovery.bases, recovery.bases[:1] * 0.5]),
        basis_index=np.zeros(shape, np.uint8),
        wavelengths_nm=WAVELENGTHS_NM,
        valid=np.ones(shape, bool),
        confidence=np.ones(shape, np.float32),
        provenance={"camera": "Nikon 5100 (NPL)"},
        edits=(Edit("glass", "red", "polygon", np.full(61, 0.5), "luminance"),),
        derived_bases=((0, 0),),
        further={ENTRY: json.loads(json.dumps(record([(0, recovery)], 1.0)))},
    )
    write_probe(path, panorama)


def with_probe(**files: Any) -> Callable[[Path], None]:
    """A probe and text files beside it; `__` in a name stands for the dot."""

    def make(folder: Path) -> None:
        probe(folder / "probe.exr")
        (folder / "region.json").write_text(json.dumps(REGION))
        mask = np.zeros((16, 32), np.uint8)
        mask[4:9, 3:20] = 255
        Image.fromarray(mask).save(folder / "mask.png")
        for name, content in files.items():
            text = content if isinstance(content, str) else json.dumps(content)
            (folder / name.replace("__", ".")).write_text(text)

    return make


def spectral(folder: Path) -> None:
    """A panorama of another program in the layout of Fichet et al."""
    from spectral_probe.files.spectral_exr import write_spectral

    nm = np.arange(400.0, 701.0, 20.0)
    spectra = np.random.default_rng(3).uniform(0.1, 1.0, (8, 16, len(nm)))
    write_spectral(folder / "spectral.exr", spectra, nm, attributes={"EV": 0.5})


def filtered(*words: str) -> tuple[str, ...]:
    """Words of `filter`."""
    return ("filter", "probe.exr", *words, "-o", "out/stained.exr")


# ---------------------------------------------------------------- renders


def swappable(folder: Path) -> None:
    """A finished render with lights that can be exchanged, one of which is."""
    from spectral_probe.swapping import swap_light

    script("core/render/test_swap.py").Rendered(folder)
    for _ in swap_light(folder, "window", lamp="HP1"):
        pass


def composed(folder: Path) -> None:
    """A finished render with objects and without, its passes, its backplate, and a plate."""
    from spectral_probe.composite.backplate_file import save_backplate
    from spectral_probe.composite_model import Backplate, ObjectCoverage
    from spectral_probe.files.image_exr import write_channels, write_rgb
    from spectral_probe.files.objects_exr import write_objects
    from spectral_probe.model import Camera
    from spectral_probe.render.pass_folder import PassFolder, digest_of, render_steps
    from spectral_probe.render.plan import reference_plan
    from spectral_probe.render.plan_file import save_plan

    verb = script("core/composite/test_composite_verb.py")
    cover, light = verb.scene()
    one, plan, size = np.ones_like(cover), reference_plan(), verb.SIZE
    record = script("core/conftest.py").frame_record.__wrapped__()()
    images = {"": (0.5 * light * (1 - cover) + cover), "without": np.full_like(cover, 0.5)}
    for name, image in images.items():
        part = folder / "render" / name
        save_plan(plan, part / "plan.json")
        passes = PassFolder(part / "passes", {}, ("ViewLayer",), digest_of(part / "plan.json"), record)
        passes.write_index()
        for step in render_steps(plan, 8):
            planes = {f"0.world.{letter}": np.float32(image) for letter in "RGB"}
            write_channels(passes.path(step.name), planes | {"0.alpha.V": one})
            passes.note(step.name, 1.0, step.samples)
        verb.write_part(part, image[..., None] * np.ones(3, np.float32), one)
    write_objects(folder / "render" / "objects.exr", ObjectCoverage({"square": cover}, cover, 1 - cover))
    write_rgb(folder / "plate.exr", verb.textured_plate())
    Image.fromarray(np.full((size, size, 3), 120, np.uint8)).save(folder / "plate.jpg")
    camera = Camera((50.0, 50.0), (20.0, 20.0), (size, size))
    plate = Backplate(camera, np.eye(3), np.zeros(3), folder / "plate.jpg", (size, size), (0.0, 0.0, size, size),
                      response_log_gain=np.full((3, len(verb.KNOTS)), 0.1), exposure=0.5)  # fmt: skip
    save_backplate(folder / "render" / "backplate.json", plate)
    views = {"views": [{"matching": {"response_log_gain": np.zeros((3, len(verb.KNOTS))).tolist()}}]}
    (folder / "response.json").write_text(json.dumps(views))


def composite(target: str, *words: str, plate: str = "plate.exr") -> Kind:
    """A file that `composite` reads."""
    return Kind(composed, target, ("composite", "render", "--plate", plate, *OUT, *words))


NIKON = ("--camera", "Nikon 5100 (NPL)")


def compared(folder: Path) -> None:
    """Two pictures, a spectral one, and a report beside them."""
    from spectral_probe.files.image_exr import write_rgb
    from spectral_probe.files.spectral_exr import write_spectral

    image = np.random.default_rng(1).uniform(0.1, 1.0, (24, 32, 3)).astype(np.float32)
    write_rgb(folder / "xyz.exr", image, "XYZ")
    write_rgb(folder / "rgb.exr", image)
    write_spectral(folder / "spectral.exr", image.repeat(11, 2)[..., :31], np.arange(400.0, 701.0, 10.0))
    (folder / "report.json").write_text(
        json.dumps({"passes": 3, "light": np.ones(61).tolist(), "seconds": {"spectral": 1.0}})
    )


def captured(**files: Any) -> Callable[[Path], None]:
    """A capture with a photograph in OpenEXR, and files that it names."""
    lines = {key: value for key, value in files.items() if "__" not in key}
    others = {key: value for key, value in files.items() if "__" in key}

    def make(folder: Path) -> None:
        room().write(folder / "view.exr")
        (folder / "capture.toml").write_text(capture_with(**lines))
        for name, content in others.items():
            text = content if isinstance(content, str) else json.dumps(content)
            (folder / name.replace("__", ".")).write_text(text)

    return make


CAMERA = {
    "focal_px": [1350.0, 1350.0], "principal_px": [100.0, 100.0], "image_size_px": [200, 200], "size_px": [200, 200],
    "distortion": [0.0, 0.0, 0.0, 0.0, 0.0], "rms_px": 0.1,
}  # fmt: skip
THREE = "wavelength_nm,r,g,b\n" + "".join(
    ",".join([str(nm), *(f"{2.0 ** -(((nm - c) / 40) ** 2):.4f}" for c in (600, 540, 460))]) + "\n"
    for nm in range(380, 721, 10)
)
PROBE_WORDS = ("probe", "capture.toml", *OUT, "--width", "64")

KINDS: dict[str, Kind] = {
    **{f"photograph {s}": Kind(ball_picture(s), f"view{s}", PROBE_WORDS) for s in (".dng", ".exr", ".hdr", ".jpg", ".tif")},
    **{
        f"board {name}": calibrate(name)
        for name in ("a.jpg", "a.png", "deep.png", "eight.tif", "float.tif", "a.dng", "a.exr", "parts.exr", "a.hdr")
    },
    "capture": Kind(captured(), "capture.toml", PROBE_WORDS),
    "camera.json": Kind(
        captured(focal_px='calibration = "camera.json"', principal_px="", camera__json=CAMERA), "camera.json", PROBE_WORDS
    ),
    "sensitivities": Kind(captured(model='sensitivities = "three.csv"', three__csv=THREE), "three.csv", PROBE_WORDS),
    "ball spectrum": Kind(captured(material='material = "ball.csv"', ball__csv=ROWS), "ball.csv", PROBE_WORDS),
    "known light": Kind(captured(families='spectra = ["lamp.csv"]', lamp__csv=ROWS), "lamp.csv", PROBE_WORDS),
    "table": Kind(with_probe(a__csv="nm,lamp\n" + ROWS), "a.csv", ("library", "show", "a.csv")),
    "SPD": Kind(with_probe(a__spd=ROWS.replace(",", " ")), "a.spd", ("library", "show", "a.spd")),
    "TM-27": Kind(with_probe(a__spdx=TM27), "a.spdx", ("library", "show", "a.spdx")),
    "AMPAS": Kind(with_probe(a__json=AMPAS), "a.json", ("library", "show", "a.json")),
    "CGATS": Kind(with_probe(a__txt=CGATS), "a.txt", ("library", "show", "a.txt")),
    "measured": Kind(
        with_probe(lamp__tsv=ROWS.replace(",", "\t")), "lamp.tsv",
        ("spectrum", "probe.exr", "--at", "10,20", "--measured", "lamp.tsv", *OUT),
    ),
    "glass": Kind(with_probe(glass__csv=ROWS), "glass.csv", filtered("--glass", "glass.csv", "--region", "region.json")),
    "lamp": Kind(with_probe(lamp__csv=ROWS), "lamp.csv", filtered("--lamp", "lamp.csv", "--region", "region.json")),
    "probe.exr": Kind(with_probe(), "probe.exr", ("spectrum", "probe.exr", "--at", "10,20", *OUT)),
    "probe.exr, edited": Kind(with_probe(), "probe.exr", filtered("--glass", "red", "--region", "region.json")),
    "probe.exr, its edits": Kind(with_probe(), "probe.exr", filtered("--remove", "1")),
    "panorama": Kind(spectral, "spectral.exr", ("spectrum", "spectral.exr", "--at", "10,20", *OUT)),
    "region": Kind(with_probe(), "region.json", ("spectrum", "probe.exr", "--region", "region.json", *OUT)),
    "seed": Kind(
        with_probe(seed__json={"seed_deg": [30, 10]}), "seed.json", filtered("--glass", "red", "--region", "seed.json")
    ),
    "mask": Kind(
        with_probe(masked__json={"mask": "mask.png"}), "mask.png", ("spectrum", "probe.exr", "--region", "masked.json", *OUT)
    ),
    **{
        f"swap {name}": Kind(swappable, name, ("swap", ".", "--light", "desk", "--lamp", "A", *OUT))
        for name in ("plan.json", "swappable.exr", "image.exr", "swaps.json", "report.json")
    },
    "composite xyz.exr": composite("render/xyz.exr"),
    "composite objects.exr": composite("render/objects.exr"),
    "composite plate": composite("plate.exr"),
    "composite plate.jpg": composite("plate.jpg", plate="plate.jpg"),
    "composite backplate.json": composite("render/backplate.json", plate="plate.jpg"),
    "composite response": composite("response.json", "--response", "response.json", plate="plate.jpg"),
    "composite plan.json": composite("render/plan.json", *NIKON),
    "composite index.json": composite("render/passes/index.json", *NIKON),
    "composite pass": composite("render/passes/pass_00.exr", *NIKON),
    "composite manifest": composite("render/passes/pass_00.json", *NIKON),
    "compare xyz.exr": Kind(compared, "xyz.exr", ("compare", "xyz.exr", "rgb.exr", *OUT)),
    "compare rgb.exr": Kind(compared, "rgb.exr", ("compare", "xyz.exr", "rgb.exr", *OUT)),
    "compare spectral.exr": Kind(compared, "spectral.exr", ("compare", "spectral.exr", "rgb.exr", *OUT)),
    "compare report.json": Kind(compared, "report.json", ("compare", "xyz.exr", "rgb.exr", *OUT)),
}  # fmt: skip


def copied(kind_folder: Path, into: Path) -> None:
    """A fresh copy of a kind's folder."""
    shutil.copytree(kind_folder, into)
