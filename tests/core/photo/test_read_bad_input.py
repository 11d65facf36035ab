"""Photographs that are broken, odd or not what they seem: one sentence that names the file and says what to do."""

import contextlib
import os
import struct
import warnings
import zlib
from pathlib import Path

import cv2
import numpy as np
import OpenEXR
import pytest
import tifffile
from PIL import Image

from spectral_probe.cli import main
from spectral_probe.errors import PhotographError
from spectral_probe.photo.exif import exposure_from_exif
from spectral_probe.photo.read import EXIF_IFD, read_photograph, srgb_to_linear

RNG = np.random.default_rng(11)
EIGHT = RNG.integers(0, 240, (60, 90, 3), np.uint8)
SIXTEEN = RNG.integers(0, 60000, (60, 90, 3), np.uint16)
FLOAT = RNG.uniform(0.1, 5.0, (60, 90, 3)).astype(np.float32)


def write_dng(path: Path, sensels: np.ndarray, orientation: int = 1) -> None:
    """A 14-bit RGGB mosaic as the smallest DNG that LibRaw reads."""
    identity = (1, 1, 0, 1, 0, 1, 0, 1, 1, 1, 0, 1, 0, 1, 0, 1, 1, 1)
    extra = [
        (271, "s", 0, "Test", True), (272, "s", 0, "Mosaic", True), (274, "H", 1, orientation, True),
        (33421, "H", 2, (2, 2), True), (33422, "B", 4, bytes([0, 1, 1, 2]), True), (33434, "2I", 1, (1, 100), True),
        (50706, "B", 4, bytes([1, 4, 0, 0]), True), (50708, "s", 0, "Test Mosaic", True), (50714, "H", 1, 512, True),
        (50717, "H", 1, 16383, True), (50721, "2i", 9, identity, True), (50728, "2I", 3, (1, 1, 1, 1, 1, 1), True),
    ]  # fmt: skip
    tifffile.imwrite(path, sensels.astype(np.uint16), photometric=32803, metadata=None, extratags=extra)


def write_exr(path: Path, channels: dict[str, np.ndarray], **header: object) -> None:
    OpenEXR.File(
        header, {name: OpenEXR.Channel(np.ascontiguousarray(plane)) for name, plane in channels.items()}
    ).write(str(path))


def write_whole(path: Path) -> None:
    """A sound photograph of the kind that the name says."""
    match path.suffix:
        case ".dng":
            write_dng(path, RNG.integers(600, 9000, (96, 128)))
        case ".exr":
            write_exr(path, {name: FLOAT[..., channel] for channel, name in enumerate("RGB")})
        case ".jpg" | ".png":
            Image.fromarray(EIGHT).save(path)
        case ".hdr":
            cv2.imwrite(str(path), FLOAT)
        case ".tif":
            cv2.imwrite(str(path), SIXTEEN)


def refusal(path: Path, **options: bool) -> str:
    """The one sentence with which a file is refused."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(PhotographError) as error:
            read_photograph(path, **options)
    text = str(error.value)
    assert path.name in text
    assert "\n" not in text
    assert text.endswith(".")
    return text


KINDS = [".dng", ".exr", ".jpg", ".png", ".hdr", ".tif"]


@pytest.mark.parametrize("suffix", KINDS)
@pytest.mark.parametrize("share", [0.02, 0.3, 0.7, 0.97])
def test_cut_short(tmp_path, capfd, suffix, share):
    """Refused, and no library writes a line of its own."""
    path = tmp_path / f"cut{suffix}"
    write_whole(path)
    assert read_photograph(path).pixels.shape[-1] == 3
    data = path.read_bytes()
    path.write_bytes(data[: max(int(len(data) * share), 12)])
    assert "cannot be read: it is" in refusal(path)
    assert "".join(capfd.readouterr()) == ""


@pytest.mark.parametrize("suffix", KINDS)
def test_empty(tmp_path, suffix):
    path = tmp_path / f"empty{suffix}"
    path.touch()
    assert "is empty (0 bytes)" in refusal(path)


@pytest.mark.parametrize("suffix", [".png", ".exr", ".hdr", ".jpg", ".tif", ".dng"])
def test_damaged_inside(tmp_path, suffix):
    """Flipped bytes: read or refused with one sentence, never a traceback."""
    path = tmp_path / f"damaged{suffix}"
    write_whole(path)
    whole = path.read_bytes()
    for seed in range(12):
        data = bytearray(whole)
        rng = np.random.default_rng(seed)
        for at in rng.integers(0, min(len(data), 400 if seed % 2 else len(data)), 6):
            data[at] = rng.integers(256)
        path.write_bytes(data)
        with contextlib.suppress(PhotographError):
            assert np.isfinite(read_photograph(path).pixels).all()


@pytest.mark.parametrize(
    ("content", "name", "advice"),
    [
        (".jpg", "a.dng", "a.dng is a JPEG picture, not what its name says. Rename it to a.jpg"),
        (".jpg", "a.png", "a.png is a JPEG picture"),
        (".png", "a.jpg", "a.jpg is a PNG picture"),
        (".tif", "a.dng", "a.dng is a TIFF picture"),
        (".exr", "a.hdr", "a.hdr is an OpenEXR picture"),
        (".hdr", "a.exr", "a.exr is a Radiance HDR picture"),
        (".dng", "a.tif", "a.tif is camera raw"),
        (".exr", "a.nef", "a.nef is an OpenEXR picture"),
    ],
)
def test_another_kind_than_the_name_says(tmp_path, content, name, advice):
    write_whole(tmp_path / f"b{content}")
    (tmp_path / f"b{content}").rename(tmp_path / name)
    text = refusal(tmp_path / name)
    assert text.startswith(advice)


@pytest.mark.parametrize("content", [".jpg", ".png", ".tif", ".exr", ".hdr"])
def test_a_name_that_says_nothing_is_no_obstacle(tmp_path, content):
    write_whole(tmp_path / f"b{content}")
    (tmp_path / f"b{content}").rename(tmp_path / "photograph")
    assert read_photograph(tmp_path / "photograph").pixels.shape == (60, 90, 3)


@pytest.mark.parametrize(
    ("head", "what"),
    [
        (b"GIF89a", "a GIF picture"), (b"RIFF\0\0\0\0WEBPVP8 ", "a WebP picture"), (b"\0\0\0\x18ftypheic", "a HEIC picture"),
        (b"%PDF-1.7", "a PDF picture"), (b"8BPS\0\1", "a Photoshop picture"),
    ],
)  # fmt: skip
def test_kinds_that_are_not_read_are_named(tmp_path, head, what):
    path = tmp_path / "a.jpg"
    path.write_bytes(head + bytes(100))
    assert what in refusal(path)


@pytest.mark.parametrize(
    ("mode", "name", "message"),
    [
        ("1", "a.png", "black and white without tones (1 bit)"), ("1", "a.tif", "black and white without tones (1 bit)"),
        ("L", "a.png", "has no colour"), ("L", "a.jpg", "has no colour"), ("L", "a.tif", "has no colour"),
        ("LA", "a.png", "has no colour"), ("I;16", "a.png", "has no colour"), ("I;16", "a.tif", "has no colour"),
        ("CMYK", "a.jpg", "is in CMYK"), ("CMYK", "a.tif", "is in CMYK"), ("LAB", "a.tif", "not RGB. Save it as RGB"),
    ],
)  # fmt: skip
def test_pictures_without_red_green_and_blue(tmp_path, mode, name, message):
    image = Image.new("I;16", (40, 30)) if mode == "I;16" else Image.new("RGB", (40, 30), (200, 90, 40))
    if mode == "LAB":
        tifffile.imwrite(tmp_path / name, EIGHT, photometric="cielab")
    elif mode == "LA":
        image.convert("L").convert("LA").save(tmp_path / name)
    else:
        (image if mode == "I;16" else image.convert(mode)).save(tmp_path / name)
    assert message in refusal(tmp_path / name)


@pytest.mark.parametrize("depth", [np.uint8, np.uint16])
@pytest.mark.parametrize("suffix", [".png", ".tif"])
def test_alpha_is_left_aside_and_grey_boards_are_read(tmp_path, depth, suffix):
    opaque = (EIGHT if depth is np.uint8 else SIXTEEN)[..., ::-1]
    alpha = np.zeros((*opaque.shape[:2], 1), depth)
    cv2.imwrite(str(tmp_path / f"rgb{suffix}"), opaque)
    cv2.imwrite(str(tmp_path / f"rgba{suffix}"), np.concatenate([opaque, alpha], axis=-1))
    plain, transparent = (read_photograph(tmp_path / f"{name}{suffix}") for name in ("rgb", "rgba"))
    np.testing.assert_array_equal(plain.pixels, transparent.pixels)
    cv2.imwrite(str(tmp_path / f"grey{suffix}"), opaque[..., 0])
    grey = read_photograph(tmp_path / f"grey{suffix}", grey=True)
    np.testing.assert_array_equal(grey.pixels[..., 1], plain.pixels[..., 2])


def test_a_palette_is_read_as_its_colours(tmp_path):
    image = Image.fromarray(np.kron(RNG.integers(0, 200, (3, 4, 3), np.uint8), np.ones((8, 8, 1), np.uint8)))
    image.quantize(16).save(tmp_path / "a.png")
    expected = srgb_to_linear(np.asarray(Image.open(tmp_path / "a.png").convert("RGB")) / 255.0)
    np.testing.assert_allclose(read_photograph(tmp_path / "a.png").pixels, expected, atol=1e-6)


def matrix_profile(curve: bytes, primaries: str = "709") -> bytes:
    """A version 2 ICC profile with one curve for all channels; Rec.709's primaries adapted to D50, or these swapped."""
    columns = [
        (0.4360747, 0.2225045, 0.0139322),
        (0.3850649, 0.7168786, 0.0971045),
        (0.1430804, 0.0606169, 0.7141733),
    ]
    if primaries == "swapped":
        columns = columns[1:] + columns[:1]
    xyz = [b"XYZ \0\0\0\0" + struct.pack(">3i", *(round(v * 65536) for v in column)) for column in columns]
    data = dict(zip((b"rXYZ", b"gXYZ", b"bXYZ"), xyz, strict=True)) | dict.fromkeys(
        (b"rTRC", b"gTRC", b"bTRC"), curve
    )
    table, body, start = b"", b"", 132 + 12 * len(data)
    for name, value in data.items():
        table += struct.pack(">4sII", name, start + len(body), len(value))
        body += value + bytes(-len(value) % 4)
    size = start + len(body)
    return (
        struct.pack(">I", size)
        + bytes(12)
        + b"RGB XYZ "
        + bytes(104)
        + struct.pack(">I", len(data))
        + table
        + body
    )


def curve_tag(*values: int) -> bytes:
    return b"curv\0\0\0\0" + struct.pack(f">I{len(values)}H", len(values), *values)


SRGB_TAG = b"para\0\0\0\0\0\3\0\0" + struct.pack(
    ">5i", *(round(v * 65536) for v in (2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045))
)


@pytest.mark.parametrize("suffix", [".tif", ".png"])
@pytest.mark.parametrize(
    ("tag", "decoded"),
    [
        (curve_tag(round(2.2 * 256)), lambda x: x ** (round(2.2 * 256) / 256)),
        (curve_tag(*(round(65535 * (i / 1023) ** 1.8) for i in range(1024))), lambda x: x**1.8),
        (SRGB_TAG, srgb_to_linear),
        (curve_tag(), None),
        (curve_tag(256), None),
    ],
)
def test_sixteen_bits_are_what_their_profile_says(tmp_path, suffix, tag, decoded):
    """Raw converters write linear values, photo editors encoded ones."""
    path = tmp_path / f"a{suffix}"
    if suffix == ".tif":
        tifffile.imwrite(path, SIXTEEN, photometric="rgb", metadata=None, iccprofile=matrix_profile(tag))
    else:
        cv2.imwrite(str(path), SIXTEEN[..., ::-1])
        chunk = png_chunk(b"iCCP", b"p\0\0" + zlib.compress(matrix_profile(tag)))
        data = path.read_bytes()
        path.write_bytes(data[:33] + chunk + data[33:])  # behind IHDR
    photograph = read_photograph(path)
    values = SIXTEEN / 65535.0
    assert photograph.display_referred == (decoded is not None)
    np.testing.assert_allclose(photograph.pixels, values if decoded is None else decoded(values), atol=2e-4)


def test_a_profile_with_other_primaries_and_a_broken_one(tmp_path):
    profile = matrix_profile(curve_tag(512), "swapped")  # red codes are green light
    tifffile.imwrite(tmp_path / "a.tif", SIXTEEN, photometric="rgb", metadata=None, iccprofile=profile)
    np.testing.assert_allclose(
        read_photograph(tmp_path / "a.tif").pixels, (SIXTEEN[..., [2, 0, 1]] / 65535.0) ** 2, atol=2e-4
    )
    tifffile.imwrite(tmp_path / "b.tif", SIXTEEN, photometric="rgb", metadata=None, iccprofile=profile[:150])
    np.testing.assert_allclose(read_photograph(tmp_path / "b.tif").pixels, SIXTEEN / 65535.0, atol=1e-6)


# ---------------------------------------------------------------- radiance


def test_pixels_that_hold_no_radiance_are_marked_and_counted(tmp_path):
    image = FLOAT.copy()
    image[2, 3, 0], image[4, 5, 1], image[6, 7, 2], image[8, 9, 0] = np.nan, np.inf, -np.inf, -3.0
    image[10, 11, 1] = -0.01  # noise about black
    write_exr(tmp_path / "a.exr", {name: image[..., channel] for channel, name in enumerate("RGB")})
    photograph = read_photograph(tmp_path / "a.exr")
    assert np.argwhere(photograph.clipped).tolist() == [[2, 3], [4, 5], [6, 7], [8, 9]]
    assert (photograph.pixels[photograph.clipped] == 0).all()
    assert photograph.pixels[10, 11, 1] == np.float32(-0.01)
    assert photograph.remarks == (
        "a.exr: 3 pixels are not finite numbers and left out.",
        "a.exr: 1 pixel is negative and left out.",
    )


def test_nothing_but_nan(tmp_path):
    write_exr(tmp_path / "a.exr", dict.fromkeys("RGB", np.full((4, 4), np.nan, np.float32)))
    assert "holds no numbers" in refusal(tmp_path / "a.exr")


@pytest.mark.parametrize(
    "names",
    [
        ("R", "G", "B"),
        ("r", "g", "b"),
        ("red", "green", "blue"),
        ("View.Combined.R", "View.Combined.G", "View.Combined.B"),
    ],
)
@pytest.mark.parametrize("dtype", [np.float32, np.float16])
@pytest.mark.parametrize("tiled", [False, True])
def test_exr_of_every_make(tmp_path, names, dtype, tiled):
    header = {"type": OpenEXR.tiledimage, "tiles": OpenEXR.TileDescription()} if tiled else {}
    planes = {name: FLOAT[..., channel].astype(dtype) for channel, name in enumerate(names)}
    write_exr(tmp_path / "a.exr", planes | {"Z": FLOAT[..., 0]}, **header)
    np.testing.assert_array_equal(
        read_photograph(tmp_path / "a.exr").pixels, FLOAT.astype(dtype).astype(np.float32)
    )


def test_exr_parts_and_layers(tmp_path):
    colour = {name: np.ascontiguousarray(FLOAT[..., channel]) for channel, name in enumerate("RGB")}
    parts = [
        OpenEXR.Part({"name": "depth"}, {"Z": colour["R"]}),
        OpenEXR.Part({"name": "beauty"}, dict(colour)),
    ]
    OpenEXR.File(parts).write(str(tmp_path / "parts.exr"))
    np.testing.assert_array_equal(read_photograph(tmp_path / "parts.exr").pixels, FLOAT)
    extra = {f"diffuse.{name}": plane for name, plane in colour.items()}
    write_exr(tmp_path / "both.exr", colour | extra)
    np.testing.assert_array_equal(read_photograph(tmp_path / "both.exr").pixels, FLOAT)
    write_exr(tmp_path / "two.exr", extra | {f"glossy.{name}": plane for name, plane in colour.items()})
    assert "holds several pictures (diffuse, glossy)" in refusal(tmp_path / "two.exr")
    write_exr(tmp_path / "luminance.exr", {"Y": FLOAT[..., 0]})
    assert "has no colour: its channels are Y" in refusal(tmp_path / "luminance.exr")
    assert read_photograph(tmp_path / "luminance.exr", grey=True).pixels.shape == (60, 90, 3)


def test_exr_that_stores_a_part_of_its_frame(tmp_path):
    """The principal point is the frame's centre, so the frame is what is read."""
    window = (np.array([10, 20], np.int32), np.array([99, 79], np.int32))
    frame = (np.array([0, 0], np.int32), np.array([119, 99], np.int32))
    colour = {name: FLOAT[..., channel] for channel, name in enumerate("RGB")}
    write_exr(tmp_path / "a.exr", colour, dataWindow=window, displayWindow=frame)
    photograph = read_photograph(tmp_path / "a.exr")
    assert photograph.pixels.shape == (100, 120, 3)
    np.testing.assert_array_equal(photograph.pixels[20:80, 10:100], FLOAT)
    assert photograph.clipped.sum() == 100 * 120 - 60 * 90


# ---------------------------------------------------------------- sizes, names, permissions


def png_chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png_of_size(width: int, height: int) -> bytes:
    chunk = png_chunk
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"IDAT", zlib.compress(bytes(5000)))
        + chunk(b"IEND", b"")
    )


def huge(kind: str, path: Path) -> None:
    """A small file that says it is 60000 x 60000 pixels."""
    write_whole(path)
    data = bytearray(path.read_bytes())
    if kind == ".png":
        data = bytearray(png_of_size(60000, 60000))
    elif kind == ".jpg":
        frame = data.index(b"\xff\xc0")
        data[frame + 5 : frame + 9] = struct.pack(">HH", 60000, 60000)
    elif kind == ".hdr":
        data = bytearray(data.replace(b"-Y 60 +X 90", b"-Y 60000 +X 60000"))
    elif kind == ".exr":
        window = data.index(b"dataWindow\0box2i\0") + len(b"dataWindow\0box2i\0") + 4
        data[window : window + 16] = struct.pack("<4i", 0, 0, 59999, 59999)
    else:
        directory = struct.unpack_from("<I", data, 4)[0]
        for entry in range(
            directory + 2, directory + 2 + 12 * struct.unpack_from("<H", data, directory)[0], 12
        ):
            if struct.unpack_from("<H", data, entry)[0] in (256, 257):
                struct.pack_into("<HII", data, entry + 2, 4, 1, 60000)
    path.write_bytes(data)


@pytest.mark.parametrize("suffix", KINDS)
def test_a_size_that_no_photograph_has_is_refused_before_it_costs_memory(tmp_path, suffix):
    path = tmp_path / f"huge{suffix}"
    huge(suffix, path)
    assert "says it is 60000 x 60000 pixels, more than the 256 megapixels" in refusal(path)


def test_a_size_that_the_file_cannot_hold_is_refused(tmp_path):
    path = tmp_path / "claims.png"
    path.write_bytes(png_of_size(15000, 15000))
    assert "is cut short" in refusal(path)


def test_the_limits_of_pillow_do_not_apply(tmp_path):
    """It would warn of 90 megapixels and refuse 179."""
    path = tmp_path / "large.jpg"
    Image.new("RGB", (2000, 1500), (180, 120, 60)).save(path, quality=30)
    with pytest.MonkeyPatch.context() as patch, warnings.catch_warnings():
        warnings.simplefilter("error")
        patch.setattr(
            Image, "MAX_IMAGE_PIXELS", 1_000_000
        )  # stands in for a picture of three times the limit
        assert read_photograph(path).pixels.shape == (1500, 2000, 3)


@pytest.mark.parametrize(
    "name", ["Kugel über Büro 球 №1.png", "a b 'c'.tif", "größe.exr", "ä.jpg", "日本.hdr", "raw é.dng"]
)
def test_names_in_any_language(tmp_path, name):
    write_whole(tmp_path / name)
    assert read_photograph(tmp_path / name).path.name == name


def test_a_folder_is_no_photograph(tmp_path):
    (tmp_path / "folder.jpg").mkdir()
    assert "is a folder. Give the photographs in it" in refusal(tmp_path / "folder.jpg")


def test_a_file_that_may_not_be_read(tmp_path, monkeypatch):
    path = tmp_path / "locked.jpg"
    write_whole(path)

    def refuse(*_args: object, **_options: object) -> None:
        raise PermissionError(13, os.strerror(13))

    monkeypatch.setattr(Path, "open", refuse)
    assert "cannot be opened (Permission denied). Check its permissions" in refusal(path)


# ---------------------------------------------------------------- orientation and EXIF


def corner_image(dtype: type) -> np.ndarray:
    """Red at the top left, green at the top right, the rest grey: the sensor's own orientation."""
    top = np.iinfo(dtype).max * 3 // 4
    image = np.full((32, 48, 3), top // 4, dtype)
    image[:16, :16], image[:16, 32:] = (top, 0, 0), (0, top, 0)
    return image


# Where the first row and the first column lie in the upright picture (EXIF 2.32, tag 0x0112).
CORNERS = {
    1: ("top left", "top right"), 2: ("top right", "top left"), 3: ("bottom right", "bottom left"),
    4: ("bottom left", "bottom right"), 5: ("top left", "bottom left"), 6: ("top right", "bottom right"),
    7: ("bottom right", "top right"), 8: ("bottom left", "top left"),
}  # fmt: skip


def corner_of(pixels: np.ndarray, channel: int) -> str:
    """The corner in which one channel stands out."""
    height, width = pixels.shape[:2]
    shown = pixels[..., channel] - pixels[..., (channel + 1) % 3]
    row, column = np.argwhere(shown > 0.8 * shown.max()).mean(0)
    return f"{'top' if row < height / 2 else 'bottom'} {'left' if column < width / 2 else 'right'}"


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize(
    "name", ["a.jpg", "a.png", "deep.png", "eight.tif", "packed.tif", "sixteen.tif", "float.tif", "a.dng"]
)
def test_orientation_tags_are_honoured(tmp_path, name, orientation):
    path = tmp_path / name
    eight, sixteen = corner_image(np.uint8), corner_image(np.uint16)
    exif = Image.Exif()
    exif[0x0112] = orientation
    if name in ("a.jpg", "a.png"):
        Image.fromarray(eight).save(path, exif=exif)
    elif name == "deep.png":
        cv2.imwrite(str(path), sixteen[..., ::-1])
        path.write_bytes(
            path.read_bytes().replace(
                png_chunk(b"IEND", b""), png_chunk(b"eXIf", exif.tobytes()[6:]) + png_chunk(b"IEND", b"")
            )
        )
    elif name == "a.dng":
        sensels = np.full((64, 96), 600.0)
        sensels[:32:2, :32:2] = sensels[:32:2, 65::2] = sensels[1:32:2, 64::2] = 9000  # red left, green right
        write_dng(path, sensels, orientation)
    else:
        data = {
            "eight": eight,
            "packed": eight,
            "sixteen": sixteen,
            "float": (sixteen / 65535).astype(np.float32),
        }[path.stem]
        tags = [(274, "H", 1, orientation, True)]
        packing = "zlib" if name == "packed.tif" else None
        tifffile.imwrite(path, data, photometric="rgb", compression=packing, metadata=None, extratags=tags)
    pixels = read_photograph(path).pixels
    assert (pixels.shape[0] > pixels.shape[1]) == (orientation >= 5)
    assert (corner_of(pixels, 0), corner_of(pixels, 1)) == CORNERS[orientation]
    if name == "a.dng":
        half = read_photograph(path, half_size=True).pixels
        assert half.shape[:2] == (pixels.shape[0] // 2, pixels.shape[1] // 2)
        assert (corner_of(half, 0), corner_of(half, 1)) == CORNERS[orientation]


@pytest.mark.parametrize(
    ("tags", "expected"),
    [
        ({0x829A: 0.0, 0x8827: 100}, None), ({0x829A: float("nan")}, None), ({0x829A: 4294967295.0}, None),
        ({0x829A: -0.01}, None), ({0x829A: "1/60"}, None), ({0x829A: 1e-12}, None),
        ({0x829A: 0.01, 0x8827: 0, 0x829D: 0}, (0.01, 100.0, 1.0)),
        ({0x829A: 0.01, 0x8827: 65535, 0x8833: 102400, 0x829D: 2.0}, (0.01, 102400.0, 2.0)),
        ({0x829A: 0.01, 0x8827: 65535, 0x829D: 1e6}, (0.01, 100.0, 1.0)),
    ],
)  # fmt: skip
def test_exposures_that_cannot_be_are_absent(tags, expected):
    exposure = exposure_from_exif(tags)
    assert (exposure and (exposure.time_s, exposure.iso, exposure.f_number)) == expected


def test_broken_exif_costs_no_picture(tmp_path):
    exif = Image.Exif()
    exif.get_ifd(EXIF_IFD)[0x829A] = 0.01
    Image.fromarray(EIGHT).save(tmp_path / "a.jpg", exif=exif)
    data = bytearray((tmp_path / "a.jpg").read_bytes())
    start = data.index(b"Exif\0\0") + 6
    data[start + 8 : start + 30] = b"\xff" * 22
    (tmp_path / "a.jpg").write_bytes(data)
    photograph = read_photograph(tmp_path / "a.jpg")
    assert photograph.exposure is None
    assert photograph.pixels.shape == (60, 90, 3)


# ---------------------------------------------------------------- half size


def test_half_size_is_the_sensels_own(tmp_path):
    sensels = np.round(RNG.uniform(400, 9000, (97, 131)))
    sensels[10, 21] = 16383
    write_dng(tmp_path / "a.dng", sensels)
    photograph = read_photograph(tmp_path / "a.dng", half_size=True)
    values = (sensels[:96, :130] - 512) / (16383 - 512)
    expected = np.stack(
        [values[::2, ::2], (values[::2, 1::2] + values[1::2, ::2]) / 2, values[1::2, 1::2]], axis=-1
    )
    np.testing.assert_allclose(photograph.pixels, expected, atol=1e-6)
    assert photograph.pixels.min() < 0  # noise below black is kept
    assert np.argwhere(photograph.clipped).tolist() == [[5, 10]]
    full = read_photograph(tmp_path / "a.dng")
    assert (photograph.exposure, photograph.camera_raw) == (full.exposure, True)


# ---------------------------------------------------------------- the command line


@pytest.mark.parametrize("suffix", KINDS)
def test_the_command_line_says_it_once_and_writes_nothing(tmp_path, capfd, suffix):
    path = tmp_path / f"cut{suffix}"
    write_whole(path)
    path.write_bytes(path.read_bytes()[:-400])
    capture = tmp_path / "capture.toml"
    capture.write_text(
        f'[camera]\nfocal_px = 900\n[[view]]\nphotos = ["{path.name}"]\nexposures_s = [0.01]\n'
    )
    assert main(["probe", str(capture), "-o", str(tmp_path / "out")]) == 2
    out, err = capfd.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert path.name in err
    assert not (tmp_path / "out").exists()
