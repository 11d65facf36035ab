"""Shares of objects from cryptomatte channels."""

import numpy as np
import pytest

from spectral_probe.errors import FileFormatError
from spectral_probe.files.cryptomatte import number_of, object_shares
from spectral_probe.files.image_exr import read_channels, write_channels

NUMBERS = {name: number_of(name) for name in ("Ball ü", "Ground", "Behind")}


@pytest.fixture
def written(tmp_path):
    """Two layers of 2 x 2 pixels; three objects overlap in the first pixel, so that they reach the second level."""

    def plane(*values):
        return np.array(values, np.float32).reshape(2, 2)

    def numbers(*names):
        held = np.array([NUMBERS.get(name, 0) for name in names], np.uint32).reshape(2, 2)
        return held.view(np.float32)

    channels = {
        "0.CryptoObject00.r": numbers("Ball ü", "Ground", "", "Ball ü"),
        "0.CryptoObject00.g": plane(0.5, 1.0, 0.0, 0.25),
        "0.CryptoObject00.b": numbers("Ground", "", "", ""),
        "0.CryptoObject00.a": plane(0.25, 0.0, 0.0, 0.0),
        "0.CryptoObject01.r": numbers("Behind", "", "", ""),
        "0.CryptoObject01.g": plane(0.125, 0.0, 0.0, 0.0),
        "0.CryptoObject01.b": numbers("", "", "", ""),
        "0.CryptoObject01.a": plane(0.0, 0.0, 0.0, 0.0),
        "1.Alpha.V": plane(0.0, 0.0, 0.0, 0.0),
    }
    write_channels(tmp_path / "m.exr", channels)
    return read_channels(tmp_path / "m.exr")[0]  # the numbers' bits must come through a file


def test_shares_by_name(written):
    found = object_shares(written, [*NUMBERS, "Never seen"], "0.")
    assert found.keys() == {*NUMBERS, "Never seen"}
    assert not found["Never seen"].any()
    np.testing.assert_array_equal(found["Ball ü"], [[0.5, 0.0], [0.0, 0.25]])
    np.testing.assert_array_equal(found["Ground"], [[0.25, 1.0], [0.0, 0.0]])
    np.testing.assert_array_equal(found["Behind"], [[0.125, 0.0], [0.0, 0.0]])


def test_a_file_without_mattes_is_refused(written):
    with pytest.raises(FileFormatError, match="which pixels show which object"):
        object_shares(written, NUMBERS, "1.")
    with pytest.raises(FileFormatError, match="which pixels show which object"):
        object_shares({"R": np.zeros((2, 2), np.float32)}, NUMBERS)


def test_no_names_have_no_shares(written):
    assert object_shares(written, [], "0.") == {}


@pytest.mark.parametrize(
    ("name", "number"), [("", 0x00800000), ("a", 0x3C2569B2), ("hello, world", 0x149BBB7F)]
)
def test_numbers_are_murmur_hashes(name, number):
    """Known values of MurmurHash3 (seed 0); that of nothing is 0, which as a float would be none."""
    assert number_of(name) == number
