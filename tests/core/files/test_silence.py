"""What C libraries write to standard error while they read is not seen; everything else is, also from several threads."""

import os
from concurrent.futures import ThreadPoolExecutor

import OpenEXR
import pytest

from spectral_probe.errors import FileFormatError, SpectralProbeError
from spectral_probe.files.image_exr import read_channels
from spectral_probe.files.silence import libraries_silenced


def test_what_is_written_within_is_not_seen(capfd):
    os.write(2, b"before ")
    with libraries_silenced():
        os.write(2, b"within")
        with libraries_silenced():
            os.write(2, b"deeper")
        os.write(2, b"still")
    os.write(2, b"after")
    assert capfd.readouterr().err == "before after"


def test_the_last_of_several_threads_lets_it_speak_again(capfd):
    def read(_):
        with libraries_silenced():
            os.write(2, b"noise")

    with ThreadPoolExecutor(4) as pool:
        list(pool.map(read, range(200)))
    os.write(2, b"after")
    assert capfd.readouterr().err == "after"


def test_a_failure_within_lets_it_speak_again(capfd):
    with pytest.raises(KeyError), libraries_silenced():
        raise KeyError
    os.write(2, b"after")
    assert capfd.readouterr().err == "after"


@pytest.mark.parametrize("compression", [OpenEXR.ZIP_COMPRESSION, OpenEXR.PIZ_COMPRESSION])
def test_openexr_says_nothing_of_a_damaged_block(tmp_path, capfd, compression):
    import numpy as np

    path = tmp_path / "a.exr"
    codes = np.random.default_rng(0).integers(0, 9, (64, 64)).astype(np.float32)
    OpenEXR.File({"compression": compression, "type": OpenEXR.scanlineimage}, {"R": codes}).write(str(path))
    data = bytearray(path.read_bytes())
    data[-400:-200] = bytes(200)
    path.write_bytes(data)
    with pytest.raises(FileFormatError, match=r"a\.exr"):
        read_channels(path)
    assert "".join(capfd.readouterr()) == ""


def test_messages_are_one_line_whatever_the_names_in_them():
    assert str(SpectralProbeError("no file a\nb\x1b[2J\udc80\u202e.")) == "no file a b [2J  ."
