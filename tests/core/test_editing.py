"""Edited light beside the probe's: a folder for every state, nothing half written, nothing of the probe changed."""

import numpy as np
import pytest

from spectral_probe.editing import edit_light, light_in, list_of, solid_angle
from spectral_probe.errors import SpectralDataError
from spectral_probe.files.image_exr import read_rgb
from spectral_probe.files.probe_exr import read_layers, read_probe, write_probe
from spectral_probe.model import SpectralPanorama, finish
from spectral_probe.spectra.colorimetry import panorama_xyz, xyz_to_rec709
from spectral_probe.spectra.edits import apply_edit, glass_edit, remove_all_edits, remove_edit
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.library import daylight

HEIGHT, WIDTH = 16, 32
MASK = np.zeros((HEIGHT, WIDTH), bool)
MASK[4:10, 3:12] = True


@pytest.fixture
def probe(tmp_path):
    whole = np.ones((HEIGHT, WIDTH), bool)
    panorama = SpectralPanorama(
        np.ones((HEIGHT, WIDTH, 1), np.float32),
        daylight(6500.0)[None, None],
        np.zeros((HEIGHT, WIDTH), np.uint8),
        WAVELENGTHS_NM,
        whole,
        whole.astype(np.float32),
    )
    write_probe(tmp_path / "probe.exr", panorama)
    return tmp_path


def red(panorama):
    return apply_edit(panorama, glass_edit(panorama, "red", "a box"), MASK)


def names(folder):
    return {file.relative_to(folder).as_posix() for file in folder.rglob("*") if file.is_file()}


def test_a_state_has_everything_that_lights_a_scene(probe):
    built = (probe / "probe.exr").read_bytes()
    light = finish(edit_light(probe, probe, red))
    assert light.directory.parent == probe / "edits"
    assert names(light.directory) == {"probe.exr", "layers.exr", "world.exr", "preview.png"}
    edited = read_probe(light.directory / "probe.exr")
    assert light.edits == list_of(edited)
    expected = np.maximum(xyz_to_rec709(panorama_xyz(edited)), 0)
    assert np.array_equal(read_rgb(light.directory / "world.exr"), expected)
    assert read_layers(light.directory / "layers.exr").residual < 1e-6
    assert (probe / "probe.exr").read_bytes() == built


def test_the_same_light_is_the_same_folder_and_not_written_again(probe):
    first = finish(edit_light(probe, probe, red))
    written = {file.name: file.stat().st_mtime_ns for file in first.directory.iterdir()}
    again = finish(edit_light(probe, probe, red))
    assert again == first
    assert {file.name: file.stat().st_mtime_ns for file in first.directory.iterdir()} == written
    twice = finish(edit_light(first.directory, probe, red))
    assert twice.directory != first.directory
    assert finish(edit_light(twice.directory, probe, lambda light: remove_edit(light, 1))) == first


def test_without_edits_it_is_the_probe_itself(probe):
    light = finish(edit_light(probe, probe, red))
    assert finish(edit_light(light.directory, probe, remove_all_edits)).directory == probe


def test_another_probe_in_the_same_folder_has_states_of_its_own(probe):
    first = finish(edit_light(probe, probe, red))
    panorama = read_probe(probe / "probe.exr")
    panorama.weights[0, 0] = 2
    write_probe(probe / "probe.exr", panorama)
    assert finish(edit_light(probe, probe, red)).directory != first.directory


def test_a_job_that_fails_or_is_stopped_leaves_nothing(probe):
    def empty(panorama):
        return apply_edit(panorama, glass_edit(panorama, "red", "nothing"), np.zeros_like(MASK))

    with pytest.raises(SpectralDataError):
        finish(edit_light(probe, probe, empty))
    assert names(probe) == {"probe.exr"}
    job = edit_light(probe, probe, red)
    while next(job).message != "Writing world.exr":
        pass
    job.close()
    assert names(probe) == {"probe.exr"}


def test_numbers_of_a_region(probe):
    panorama = read_probe(probe / "probe.exr")
    assert solid_angle(np.ones_like(MASK)) == pytest.approx(4 * np.pi)
    assert light_in(panorama, MASK)["xy"] == pytest.approx([0.3127, 0.329], abs=1e-3)
    assert list_of(panorama) == []
