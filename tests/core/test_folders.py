"""Verbs on folders that are being written, are full, or may not be written to: one sentence, and what was there stays."""

import errno
import os
import shutil

import numpy as np
import pytest

from spectral_probe.cli import main
from spectral_probe.errors import FileFormatError
from spectral_probe.files.lock import folder_lock
from spectral_probe.model import SpectralPanorama, finish
from spectral_probe.probe import Probe, write_outputs
from spectral_probe.spectra.basis import principal_components
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.library import training_lights


@pytest.mark.parametrize(
    "words",
    [
        ["probe", "a.toml"],
        ["probe", "."],
        ["compare", "a.exr", "b.exr"],
        ["composite", "render"],
        ["swap", "render", "--light", "window", "--lamp", "A"],
    ],
)
def test_a_folder_that_is_being_written_is_refused_by_every_verb(words, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.toml").write_text("[[view]]\nphotos = ['a.png']\n")
    (tmp_path / "a.png").touch()
    with folder_lock(tmp_path / "out"):
        assert main([*words, "-o", str(tmp_path / "out")]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert "is being written by another job of this process" in err
    assert err.count("\n") == 1


@pytest.fixture(scope="module")
def probe():
    basis = principal_components(training_lights(["incandescent", "daylight"]), 3)
    spectra = np.broadcast_to(training_lights(["daylight"])[6], (32, 64, 61))
    weights = (spectra @ basis.T).astype(np.float32)
    seen, sure = np.ones((32, 64), bool), np.ones((32, 64), np.float32)
    panorama = SpectralPanorama(
        weights, basis[None], np.zeros((32, 64), np.uint8), WAVELENGTHS_NM, seen, sure
    )
    return Probe(panorama, {"seconds": {}})


@pytest.fixture(scope="module")
def earlier(probe, tmp_path_factory):
    """The folder of a probe."""
    folder = tmp_path_factory.mktemp("earlier")
    finish(write_outputs(probe, folder))
    return folder


@pytest.mark.parametrize(("number", "calls_before"), [(errno.EDQUOT, 5), (errno.ENOSPC, 8)])
def test_a_probe_that_the_disk_does_not_take_leaves_the_earlier_one(
    probe, earlier, tmp_path, monkeypatch, number, calls_before
):
    shutil.copytree(earlier, tmp_path, dirs_exist_ok=True)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    sync, left = os.fsync, [calls_before]

    def full(file):
        if not left[0]:
            raise OSError(number, os.strerror(number))
        left[0] -= 1
        sync(file)

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(FileFormatError, match="cannot be written") as told:
        finish(write_outputs(probe, tmp_path))
    assert os.strerror(number) in str(told.value)
    assert ".writing-" not in str(told.value)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
