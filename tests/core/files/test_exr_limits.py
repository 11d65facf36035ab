"""Headers of OpenEXR files that claim what cannot be: refused before anything is allocated, with one sentence."""

import struct

import numpy as np
import OpenEXR
import pytest

from spectral_probe.errors import FileFormatError
from spectral_probe.files import exr_limits
from spectral_probe.files.image_exr import read_channels, write_channels

CODECS = ["NO", "RLE", "ZIPS", "ZIP", "PIZ", "PXR24", "B44", "B44A", "DWAA", "DWAB", "HTJ2K32", "HTJ2K256"]


def at_value(data: bytes, name: bytes, kind: bytes) -> int:
    """Where an attribute's value begins."""
    return data.index(name + b"\0" + kind + b"\0") + len(name) + len(kind) + 6


@pytest.fixture
def picture(tmp_path):
    path = tmp_path / "picture.exr"
    write_channels(path, dict.fromkeys("RGB", np.ones((40, 60), np.float32)))
    return path


def changed(path, at, values):
    data = bytearray(path.read_bytes())
    data[at : at + len(values)] = values
    path.write_bytes(data)


def refusal(path) -> str:
    with pytest.raises(FileFormatError) as error:
        read_channels(path)
    text = str(error.value)
    assert path.name in text
    assert "\n" not in text
    return text


@pytest.mark.parametrize("codec", CODECS)
@pytest.mark.parametrize("kind", [np.float16, np.float32, np.uint32])
@pytest.mark.parametrize("tiled", [False, True])
def test_black_pictures_are_within_the_limits_of_every_codec(tmp_path, codec, kind, tiled):
    """They pack the tightest of all."""
    path = tmp_path / "black.exr"
    header = {"type": OpenEXR.tiledimage, "tiles": OpenEXR.TileDescription()} if tiled else {}
    compression = getattr(OpenEXR, f"{codec}_COMPRESSION")
    names = [f"layer.{number:02d}" for number in range(8)]
    black = np.zeros((300, 520), kind)
    OpenEXR.File({"compression": compression, **header}, dict.fromkeys(names, black)).write(str(path))
    (part,) = exr_limits.check_exr(path)
    assert (part.width, part.height, part.channels) == (520, 300, tuple(names))
    assert part.pixel_bytes == 8 * black.nbytes
    assert not read_channels(path)[0][names[0]].any()


@pytest.mark.parametrize(
    "window",
    [
        (0, 0, 2**31 - 1, 2**31 - 1), (0, 0, 1 << 20, 39), (0, 0, 59, 1 << 20), (5, 5, 4, 4), (-(2**31), 0, 2**31 - 1, 0),
        (0, 0, 9_999_999, 39), (0, 0, 59, 10_000),
    ],
)  # fmt: skip
def test_windows_that_the_file_cannot_hold(picture, window):
    changed(picture, at_value(picture.read_bytes(), b"dataWindow", b"box2i"), struct.pack("<4i", *window))
    assert "cannot be read" in refusal(picture)


def test_lengths_of_attributes_beyond_the_file(picture):
    changed(picture, at_value(picture.read_bytes(), b"channels", b"chlist") - 4, struct.pack("<I", 2**32 - 1))
    assert "cut short" in refusal(picture)


@pytest.mark.parametrize("sampling", [(0, 1), (1, -1), (0, 0)])
def test_sampling_that_is_none(picture, sampling):
    at = at_value(picture.read_bytes(), b"channels", b"chlist")
    changed(picture, at + 2 + 8, struct.pack("<2i", *sampling))
    assert "broken" in refusal(picture)


@pytest.mark.parametrize("size", [(0, 64), (2**32 - 1, 2**32 - 1), (1 << 20, 1 << 12)])
def test_tiles_of_no_size_or_too_large(tmp_path, size):
    path = tmp_path / "tiled.exr"
    header = {"type": OpenEXR.tiledimage, "tiles": OpenEXR.TileDescription()}
    OpenEXR.File(header, dict.fromkeys("RGB", np.ones((70, 70), np.float32))).write(str(path))
    changed(path, at_value(path.read_bytes(), b"tiles", b"tiledesc"), struct.pack("<2I", *size))
    assert "broken" in refusal(path)


def test_two_windows_leave_open_which_one_counts(picture):
    data = picture.read_bytes()
    start = data.index(b"dataWindow\0")
    entry = data[start : start + len(b"dataWindow\0box2i\0") + 4 + 16]
    picture.write_bytes(data[:start] + entry + data[start:])
    assert "broken" in refusal(picture)


def test_deep_pictures_are_not_asked_for_their_samples(picture):
    changed(picture, 4, struct.pack("<I", 2 | 0x800))
    assert "deep" in refusal(picture)


def test_pictures_larger_than_the_free_memory_are_not_read_whole(picture, monkeypatch):
    """But their headers are: a reader by rows needs no more."""
    import psutil

    memory = psutil.virtual_memory()._replace(available=20_000)
    monkeypatch.setattr(psutil, "virtual_memory", lambda: memory)
    assert "Close other programs" in refusal(picture)
    assert exr_limits.check_exr(picture)[0].pixel_bytes == 60 * 40 * 12


def test_sixteen_gigabytes_of_half_channels_may_be_read_by_rows(tmp_path):
    """16384 x 8192 pixels, 61 channels, uncompressed, its pixels a hole in the file."""
    path = tmp_path / "large.exr"
    names = [f"S0.{nm},000000nm" for nm in range(400, 701, 5)]
    planes = dict.fromkeys(names, np.zeros((1, 16384), np.float16))
    OpenEXR.File({"compression": OpenEXR.NO_COMPRESSION}, planes).write(str(path))
    data = bytearray(path.read_bytes())
    row = 16384 * 61 * 2 + 8
    table = len(data) - row - 8
    for name in (b"dataWindow", b"displayWindow"):
        at = at_value(bytes(data), name, b"box2i")
        data[at : at + 16] = struct.pack("<4i", 0, 0, 16383, 8191)
    begin = table + 8 * 8192
    offsets = np.arange(8192, dtype="<u8") * row + begin
    with path.open("wb") as file:
        file.write(bytes(data[:table]) + offsets.tobytes())
        file.seek(begin + 8191 * row)
        file.write(struct.pack("<2i", 8191, row - 8))
        file.truncate(begin + 8192 * row)
    (part,) = exr_limits.check_exr(path)
    assert part.pixel_bytes == 16384 * 8192 * 61 * 2
    assert part.blocks == 8192
