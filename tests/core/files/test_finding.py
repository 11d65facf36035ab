"""Moved files are found by name, the one whose folders are called most alike."""

import pytest

from spectral_probe.errors import FileFormatError
from spectral_probe.files.finding import find_files
from spectral_probe.model import finish


@pytest.fixture
def folder(tmp_path):
    for name in ("v0.dng", "b/v0.dng", "a/day/v0.dng", "a/night/v0.dng", "a/night/v1.dng"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    return tmp_path


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("/gone/night/v0.dng", "a/night/v0.dng"),
        (r"D:\gone\day\v0.dng", "a/day/v0.dng"),
        ("/gone/other/v0.dng", "v0.dng"),  # none alike: the highest
        ("/gone/a/night/v1.dng", "a/night/v1.dng"),
    ],
)
def test_the_likeliest_of_one_name(folder, old, new):
    assert finish(find_files(folder, [old])) == {old: folder / new}


def test_what_is_not_there_is_left_out(folder):
    assert finish(find_files(folder, ["/gone/v9.dng", ""])) == {}


def test_no_folder(folder):
    with pytest.raises(FileFormatError, match="is no folder"):
        finish(find_files(folder / "nowhere", ["v0.dng"]))
