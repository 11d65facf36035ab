"""Images written some rows at a time are to the byte what the library writes whole, and need the memory of a few rows."""

import json
import subprocess
import sys

import numpy as np
import OpenEXR
import pytest

from spectral_probe.errors import FileFormatError
from spectral_probe.files import exr_rows
from spectral_probe.files.image_exr import open_rows, read_channels, write_channels, write_rows

HEADER = {
    "comments": "Weißpunkt: D65",
    "EV": 0.5,
    "number": 3,
    "chromaticities": (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329),
    "spectralLayoutVersion": "1.0",
}


def planes(height, width, count=5):
    rng = np.random.default_rng(height)
    kinds = [np.float16, np.float32, np.uint32]
    return {
        f"S0.{400 + 5 * n},000000nm": (100 * rng.random((height, width))).astype(kinds[n % 3])
        for n in range(count)
    }


@pytest.fixture
def few_rows(monkeypatch):
    monkeypatch.setattr(exr_rows, "_BYTES_AT_A_TIME", 20_000)


@pytest.mark.usefixtures("few_rows")
@pytest.mark.parametrize("compression", ["ZIP", "ZIPS", "RLE", "NO"])
@pytest.mark.parametrize("size", [(1, 1), (16, 40), (17, 40), (100, 333), (7, 5000)])
def test_rows_make_the_file_that_the_library_writes_whole(size, compression, tmp_path):
    channels = planes(*size)
    attributes = HEADER | {
        "compression": getattr(OpenEXR, f"{compression}_COMPRESSION"),
        "type": OpenEXR.scanlineimage,
    }
    OpenEXR.File(dict(attributes), dict(channels)).write(str(tmp_path / "whole.exr"))
    write_channels(tmp_path / "rows.exr", channels, attributes)
    assert (tmp_path / "rows.exr").read_bytes() == (tmp_path / "whole.exr").read_bytes()


@pytest.mark.usefixtures("few_rows")
@pytest.mark.parametrize("size", [(1, 1), (100, 333)])
def test_rows_read_are_those_of_the_whole_image(size, tmp_path):
    channels = planes(*size)
    write_channels(tmp_path / "a.exr", channels, HEADER)
    whole, header = read_channels(tmp_path / "a.exr")
    with open_rows(tmp_path / "a.exr") as image:
        assert (image.height, image.width) == size
        assert set(image.names) == set(channels)
        assert {name: image.header[name] for name in HEADER if name != "chromaticities"} == {
            name: header[name] for name in HEADER if name != "chromaticities"
        }
        parts = [image.read(image.names, rows) for rows in image.blocks()]
    assert len(parts) == 1 if size == (1, 1) else len(parts) > 3
    for name, plane in channels.items():
        read = np.concatenate([part[name] for part in parts])
        assert read.dtype == plane.dtype
        assert np.array_equal(read, plane)
        assert np.array_equal(whole[name], plane)


def test_an_image_that_begins_elsewhere_is_read(tmp_path):
    plane = np.arange(60.0, dtype=np.float32).reshape(6, 10)
    window = (np.array([5, -3], np.int32), np.array([14, 2], np.int32))
    OpenEXR.File({"dataWindow": window}, {"Y": plane}).write(str(tmp_path / "a.exr"))
    with open_rows(tmp_path / "a.exr") as image:
        assert np.array_equal(image.read(["Y"], slice(2, 5))["Y"], plane[2:5])


def test_a_tiled_image_is_read_by_rows(tmp_path):
    plane = np.random.default_rng(3).random((70, 50)).astype(np.float32)
    tiles = OpenEXR.TileDescription()
    tiles.xSize = tiles.ySize = 32
    OpenEXR.File({"type": OpenEXR.tiledimage, "tiles": tiles}, {"Y": plane}).write(str(tmp_path / "a.exr"))
    with open_rows(tmp_path / "a.exr") as image:
        assert np.array_equal(image.read(["Y"], slice(20, 50))["Y"], plane[20:50])


@pytest.mark.parametrize("share", [0.5, 0.95])
def test_a_file_cut_short_is_one_sentence(share, tmp_path):
    write_channels(tmp_path / "a.exr", planes(100, 333))
    content = (tmp_path / "a.exr").read_bytes()
    (tmp_path / "a.exr").write_bytes(content[: int(share * len(content))])
    with pytest.raises(FileFormatError, match="cut short"):
        open_rows(tmp_path / "a.exr")


def test_damaged_rows_are_one_sentence(tmp_path):
    write_channels(tmp_path / "a.exr", planes(100, 333))
    content = bytearray((tmp_path / "a.exr").read_bytes())
    content[len(content) // 2 : len(content) // 2 + 20_000] = bytes(20_000)
    (tmp_path / "a.exr").write_bytes(content)
    with pytest.raises(FileFormatError, match="cannot be read"), open_rows(tmp_path / "a.exr") as image:
        image.read(image.names, slice(0, 100))


@pytest.mark.usefixtures("few_rows")
def test_what_fails_while_rows_are_made_leaves_nothing(tmp_path):
    def make(rows):
        if rows.start > 50:
            raise RuntimeError("no more")
        return {"Y": np.zeros((rows.stop - rows.start, 100), np.float32)}

    with pytest.raises(RuntimeError, match="no more"):
        write_rows(tmp_path / "a.exr", (1000, 100), make)
    assert not list(tmp_path.iterdir())


MEASURE = """
import json, resource, sys
from pathlib import Path
import numpy as np
from spectral_probe.files.image_exr import open_rows, write_rows
from spectral_probe.files.spectral_channels import channel_name

path, height = Path(sys.argv[1]), int(sys.argv[2])
names = [channel_name(nm) for nm in range(400, 701, 5)]
def make(rows):
    plane = np.arange(rows.start, rows.stop, dtype=np.float16)[:, None].repeat(1024, 1)
    return dict.fromkeys(names, plane)
write_rows(path, (height, 1024), make)
total = 0.0
with open_rows(path) as image:
    for rows in image.blocks():
        total += float(image.read(image.names, rows)[names[-1]].sum(dtype=float))
print(json.dumps([resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024, total]))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="peaks are told in other units elsewhere")
def test_memory_does_not_grow_with_the_image(tmp_path):
    """61 bands of 1024 x 2048 pixels are 268 MB as 16-bit floats; a few rows of them are a few MB."""
    peaks = {}
    for height in (64, 2048):
        command = [sys.executable, "-c", MEASURE, str(tmp_path / "a.exr"), str(height)]
        told = subprocess.run(command, check=True, capture_output=True, text=True)
        peaks[height], total = json.loads(told.stdout)
        assert total == 1024 * height * (height - 1) / 2
    assert peaks[2048] < peaks[64] + 100
