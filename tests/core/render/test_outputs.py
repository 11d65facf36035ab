"""Files of a render: what they hold, and that they read back as the same colours."""

import argparse
from pathlib import Path

import numpy as np
import pytest

from spectral_probe.cli_output import add_output_words, output_settings_of
from spectral_probe.commands import read_xyz
from spectral_probe.errors import SpectralDataError
from spectral_probe.files.image_exr import read_channels, read_rgb
from spectral_probe.files.spectral_exr import read_spectral
from spectral_probe.render.assemble import AssembledRender
from spectral_probe.render.outputs import bands_wanted, output_settings, write_outputs, write_rgb_twin
from spectral_probe.render.plan import reference_plan
from spectral_probe.render_model import PassPlan
from spectral_probe.spectra.colorimetry import illuminant, spectra_to_xyz
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.working_space import WorkingSpace, working_space

NODES_NM = np.array([450.0, 550.0, 650.0])
# What Blender's Color.from_scene_linear_to_rec709_linear gives for these working spaces.
ACESCG = np.array(
    [[1.70505, -0.62179, -0.08326], [-0.13026, 1.14080, -0.01055], [-0.02400, -0.12897, 1.15297]]
)
REC2020 = np.array(
    [[1.66049, -0.58764, -0.07285], [-0.12455, 1.13290, -0.00835], [-0.01815, -0.10058, 1.11873]]
)


def plan() -> PassPlan:
    weights = np.stack([np.interp(WAVELENGTHS_NM, NODES_NM, unit) for unit in np.eye(3)])
    return PassPlan(
        kind="light-basis",
        wavelengths_nm=np.repeat(NODES_NM[:, None], 3, axis=1),
        reconstruction=weights[:, None, :] * np.ones((1, 3, 61)),
        grid_nm=WAVELENGTHS_NM,
        sample_shares=np.ones(3),
        references=(0, 1, 2),
        light_sets=(0, 0, 0),
        interpolation=weights,
    )


def render_of(spectra: np.ndarray, wanted_nm: np.ndarray, *, alpha: bool = False) -> AssembledRender:
    index = np.searchsorted(WAVELENGTHS_NM, wanted_nm)
    return AssembledRender(
        xyz=spectra_to_xyz(spectra).astype(np.float32),
        alpha=np.full(spectra.shape[:2], 0.25, np.float32) if alpha else None,
        bands_nm=wanted_nm,
        bands=np.ascontiguousarray(np.moveaxis(spectra[..., index], -1, 0)),
    )


@pytest.fixture
def spectra() -> np.ndarray:
    """(4, 5, 61) of positive, saturated and grey light."""
    rng = np.random.default_rng(3)
    return (rng.uniform(0, 1, (4, 5, 61)) ** 4 * illuminant("FL2") / 50).astype(np.float32)


@pytest.mark.parametrize(
    ("matrix", "name"), [(np.eye(3), "Rec.709"), (REC2020, "Rec.2020"), (ACESCG, "ACEScg")]
)
def test_pictures_read_back_from_every_working_space(
    tmp_path: Path, spectra: np.ndarray, matrix: np.ndarray, name: str
) -> None:
    space = working_space(matrix)
    settings = output_settings()
    assembled = render_of(spectra, bands_wanted(plan(), settings))
    files = write_outputs(tmp_path, plan(), assembled, settings, space=space)
    np.testing.assert_allclose(read_xyz(files["image"]), assembled.xyz, rtol=2e-3, atol=2e-3)
    _, header = read_channels(files["image"])
    assert name in header["comments"]
    assert "no chromatic adaptation" in header["comments"]
    rec709 = np.array([0.2, 0.5, 0.9])
    write_rgb_twin(tmp_path / "rgb.exr", np.broadcast_to(rec709, (2, 2, 3)), None, settings, space)
    np.testing.assert_allclose(
        read_xyz(tmp_path / "rgb.exr")[0, 0], working_space().to_xyz(rec709), rtol=2e-3
    )


def test_adapted_pictures_are_read_back_as_they_were(tmp_path: Path, spectra: np.ndarray) -> None:
    """Comparing an adapted picture with tristimulus values, which never are, must not show the adaptation."""
    settings = output_settings(white="A")
    assembled = render_of(spectra, bands_wanted(plan(), settings))
    files = write_outputs(tmp_path, plan(), assembled, settings)
    np.testing.assert_allclose(read_xyz(files["image"]), assembled.xyz, rtol=2e-3, atol=2e-2)
    plain = write_outputs(tmp_path, plan(), assembled, output_settings(), suffix="_plain")["image"]
    assert not np.allclose(read_rgb(files["image"]), read_rgb(plain), rtol=0.1)


def test_acescg_says_its_standard_chromaticities() -> None:
    assert working_space(ACESCG).chromaticities == pytest.approx(
        (0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767)
    )


def test_an_unknown_space_keeps_its_matrix() -> None:
    matrix = np.array([[0.8, 0.1, 0.1], [0.1, 0.85, 0.05], [0.02, 0.03, 0.95]])
    space = working_space(matrix)
    assert space.name == "scene-linear"
    assert isinstance(space, WorkingSpace)


def test_the_multilayer_file_holds_everything_at_once(tmp_path: Path, spectra: np.ndarray) -> None:
    assembled = render_of(spectra, NODES_NM, alpha=True)
    files = write_outputs(tmp_path, plan(), assembled, output_settings())
    channels, _ = read_channels(files["render"])
    assert set(channels) == set("XYZRGBA") | {f"S0.{nm:.0f},000000nm" for nm in NODES_NM}
    read, wavelengths_nm = read_spectral(files["render"])
    np.testing.assert_array_equal(wavelengths_nm, NODES_NM)
    np.testing.assert_array_equal(read, spectra[..., np.searchsorted(WAVELENGTHS_NM, NODES_NM)])
    np.testing.assert_array_equal(read_xyz(files["render"]), assembled.xyz)
    assert "spectral" not in files
    assert "swappable" not in files


def test_all_wavelengths_on_demand(tmp_path: Path, spectra: np.ndarray) -> None:
    settings = output_settings(spectral=True)
    wanted = bands_wanted(plan(), settings)
    files = write_outputs(tmp_path, plan(), render_of(spectra, wanted), settings)
    read, wavelengths_nm = read_spectral(files["spectral"])
    np.testing.assert_array_equal(wavelengths_nm, WAVELENGTHS_NM)
    np.testing.assert_allclose(read, spectra, rtol=1e-3, atol=1e-4)  # 16-bit floats
    assert len(bands_wanted(reference_plan(), output_settings())) == 61


@pytest.mark.parametrize("white", ["A", "2700 K", "0.46, 0.41"])
def test_the_stated_white_becomes_neutral_in_pictures_only(tmp_path: Path, white: str) -> None:
    settings = output_settings(white=white)
    assert settings.white is not None
    x, y = settings.white.xy
    xyz = np.full((2, 2, 3), [x / y, 1.0, (1 - x - y) / y], np.float32)
    assembled = AssembledRender(xyz, bands_nm=NODES_NM, bands=np.ones((3, 2, 2), np.float32))
    files = write_outputs(tmp_path, plan(), assembled, settings, space=working_space(REC2020))
    channels, header = read_channels(files["image"])
    np.testing.assert_allclose([channels[name] for name in "RGB"], 1.0, rtol=2e-3)
    assert "CAT16" in header["comments"]
    np.testing.assert_array_equal(read_xyz(files["xyz"]), xyz)


@pytest.mark.parametrize("white", ["900 K", "0.8,0.7", "sunny"])
def test_a_white_that_is_none_is_refused_in_one_line(white: str) -> None:
    with pytest.raises(SpectralDataError) as caught:
        output_settings(white=white)
    assert "\n" not in str(caught.value)


def test_the_command_line_has_the_same_settings() -> None:
    parser = argparse.ArgumentParser()
    add_output_words(parser)
    assert output_settings_of(parser.parse_args([])) == output_settings()
    given = parser.parse_args(["--spectral", "--white", "5000 K", "--no-denoise"])
    assert output_settings_of(given) == output_settings(spectral=True, white="5000 K", denoise=False)
