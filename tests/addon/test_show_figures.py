"""Plots as pictures in Blender: what the functions draw, shown from the operators."""

import math
from pathlib import Path

import bpy
import numpy as np
import pytest

ops = bpy.ops.spectral_probe


def finish(job):
    while True:
        try:
            next(job)
        except StopIteration as stop:
            return stop.value


@pytest.fixture(scope="module")
def made(tmp_path_factory, in_extension) -> Path:
    """A probe of daylight above and filament light below; the nadir unseen."""
    colorimetry, grid = (
        in_extension("spectral_probe.spectra.colorimetry"),
        in_extension("spectral_probe.spectra.grid"),
    )
    model, probe = in_extension("spectral_probe.model"), in_extension("spectral_probe.probe")
    weights = np.zeros((32, 64, 3), np.float32)
    weights[:16, :, 0] = weights[16:, :, 1] = 1
    valid = np.ones((32, 64), bool)
    valid[-1] = False
    panorama = model.SpectralPanorama(
        weights=weights,
        bases=np.stack([colorimetry.illuminant(name) for name in ("D65", "A", "FL11")])[None],
        basis_index=np.zeros((32, 64), np.uint8),
        wavelengths_nm=grid.WAVELENGTHS_NM,
        valid=valid,
        confidence=np.full((32, 64), 0.9, np.float32),
    )
    folder = tmp_path_factory.mktemp("probe")
    finish(probe.write_outputs(probe.Probe(panorama, {"seconds": {}}), folder))
    return folder


@pytest.fixture
def looking_down(settings, made):
    """Settings that look at the filament light."""
    settings.probe_directory = str(made)
    settings.spectrum.azimuth, settings.spectrum.elevation = math.radians(30), math.radians(-40)
    return settings


def shown(name):
    return bpy.data.images[f"Spectral Probe {name}"]


def test_show_spectrum_keeps_the_functions_numbers_and_shows_the_plot(looking_down, made, in_extension):
    assert ops.show_spectrum() == {"FINISHED"}
    spectrum = in_extension("spectral_probe.spectrum_command").spectrum
    expected = finish(spectrum(made / "probe.exr", (30.0, -40.0), None, made / "again"))
    kept = looking_down.spectrum
    assert kept.has_numbers
    assert not kept.has_comparison
    assert kept.cct_kelvin == pytest.approx(expected["cct_kelvin"])
    assert kept.ra == pytest.approx(expected["ra"])
    picture = shown("Spectrum")
    assert Path(picture.filepath) == made / "spectrum_30_-40.png"
    assert picture.size[0] == 900
    for suffix in (".csv", ".svg"):
        assert (made / f"spectrum_30_-40{suffix}").read_bytes() == (
            made / "again" / f"spectrum_30_-40{suffix}"
        ).read_bytes()


def test_show_spectrum_compares_with_a_measured_one(looking_down, tmp_path, in_extension):
    light = in_extension("spectral_probe.spectra.colorimetry").illuminant("D65")
    rows = [f"{400 + 5 * index},{value}" for index, value in enumerate(light)]
    (tmp_path / "d65.csv").write_text("wavelength_nm,radiance\n" + "\n".join(rows))
    looking_down.spectrum.measured = str(tmp_path / "d65.csv")
    assert ops.show_spectrum() == {"FINISHED"}
    kept = looking_down.spectrum
    assert kept.has_comparison
    assert kept.gfc == pytest.approx(0.805, abs=0.001)
    assert kept.de2000_light > 20
    looking_down.spectrum.measured = str(tmp_path / "lost.csv")
    with pytest.raises(RuntimeError, match=r"lost\.csv"):
        ops.show_spectrum()


def test_a_direction_that_no_view_saw_is_reported(looking_down):
    looking_down.spectrum.elevation = -math.pi / 2
    with pytest.raises(RuntimeError, match="No view saw the direction 30,-90"):
        ops.show_spectrum()


@pytest.mark.usefixtures("looking_down")
def test_show_basis(made):
    assert ops.show_basis() == {"FINISHED"}
    assert Path(shown("Basis").filepath) == made / "spectrum_30_-40_basis.png"


def test_show_confidence(looking_down, made, in_extension):
    (made / "confidence.png").unlink()
    assert ops.show_confidence() == {"FINISHED"}
    picture = shown("Confidence")
    read_probe = in_extension("spectral_probe.files.probe_exr").read_probe
    expected = in_extension("spectral_probe.figures.confidence").confidence_preview(
        read_probe(Path(looking_down.probe_directory) / "probe.exr")
    )
    width, height = picture.size
    pixels = np.array(picture.pixels[:]).reshape(height, width, 4)[::-1, :, :3]
    np.testing.assert_array_equal(np.rint(255 * pixels), expected)


def test_show_sensitivities_of_the_camera_chosen(settings):
    settings.camera.model = "Nikon 5100 (NPL)"
    assert ops.show_sensitivities() == {"FINISHED"}
    first = Path(shown("Sensitivities").filepath).with_suffix(".csv").read_text()
    settings.camera.model = ""
    assert ops.show_sensitivities() == {"FINISHED"}
    assert Path(shown("Sensitivities").filepath).with_suffix(".csv").read_text() != first
    settings.camera.model = "Nikon 5101 (NPL)"
    with pytest.raises(RuntimeError, match='Did you mean "Nikon 5100'):
        ops.show_sensitivities()


@pytest.mark.parametrize("verb", ["show_spectrum", "show_basis", "show_confidence"])
def test_without_a_probe_the_buttons_say_why(settings, tmp_path, verb):
    settings.probe_directory = str(tmp_path)
    with pytest.raises(RuntimeError, match="Build the probe first"):
        getattr(ops, verb)()


def test_showing_again_replaces_the_picture(looking_down):
    ops.show_spectrum()
    looking_down.spectrum.elevation = math.radians(40)
    ops.show_spectrum()
    assert [image.name for image in bpy.data.images if "Spectrum" in image.name] == [
        "Spectral Probe Spectrum"
    ]
    assert "spectrum_30_40" in shown("Spectrum").filepath
