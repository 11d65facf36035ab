"""Plans of passes: the reference, light-basis plans, and their files."""

import json

import numpy as np
import pytest

from spectral_probe.errors import FileFormatError, RenderError
from spectral_probe.render.plan import (
    TARGET_MAX_DE2000,
    TARGET_MEAN_DE2000,
    light_basis_plan,
    load_plan,
    reference_plan,
    save_plan,
)
from spectral_probe.spectra.colorimetry import delta_e_2000, illuminant, spectra_to_xyz
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.library import planck, surface_reflectances
from spectral_probe.spectra.metals import metal_reflectance

ANGLES = np.cos(np.radians([0.0, 30.0, 60.0, 80.0]))


@pytest.fixture(scope="module")
def metals():
    return np.concatenate([metal_reflectance(metal, ANGLES) for metal in ("Au", "Ag", "Cu")])


@pytest.fixture(scope="module")
def layers():
    """Filament light, daylight, and a tube with mercury lines."""
    lights = np.stack([planck(2856.0), illuminant("D65"), illuminant("FL2")])
    return lights / lights.mean(1, keepdims=True)


def test_the_reference_holds_each_wavelength_once():
    plan = reference_plan()
    assert plan.passes == 21
    spectrum = np.random.default_rng(0).random(61)
    passes = np.interp(plan.wavelengths_nm, WAVELENGTHS_NM, spectrum)
    np.testing.assert_allclose(np.einsum("pc,pcl->l", passes, plan.reconstruction), spectrum, atol=1e-15)
    assert (plan.reconstruction.sum(2) == 0).sum() == 2  # the padding channels


def test_the_reference_pairs_distant_wavelengths():
    spread = np.ptp(reference_plan().wavelengths_nm[:18], axis=1)
    assert spread.min() > 150


@pytest.mark.parametrize("passes", [1, 3, 5, 9])
def test_constants_and_nodes_are_exact(layers, metals, passes):
    plan = light_basis_plan(layers, metals, passes)
    assert plan.passes == passes
    np.testing.assert_allclose(plan.reconstruction.sum(0), layers, rtol=1e-9)
    nodes = np.searchsorted(WAVELENGTHS_NM, plan.wavelengths_nm[:, 0])
    at_nodes = plan.reconstruction[:, :, nodes] / layers[None, :, nodes]
    np.testing.assert_allclose(at_nodes, np.eye(passes)[:, None].repeat(3, 1), atol=1e-9)


def test_all_channels_of_a_light_basis_pass_share_a_wavelength(layers, metals):
    plan = light_basis_plan(layers, metals, 5)
    assert (plan.wavelengths_nm == plan.wavelengths_nm[:, :1]).all()


def colour_errors(plan, layers, metals):
    """dE2000 over every product of two of the metals' reflectances under each layer; not what the planner predicts with."""
    transport = (metals[:, None] * metals[None]).reshape(-1, 61)
    nodes = np.searchsorted(WAVELENGTHS_NM, plan.wavelengths_nm[:, 0])
    errors = []
    for index, light in enumerate(layers):
        spectra = transport[:, nodes] @ plan.reconstruction[:, index]
        white = spectra_to_xyz(light)
        errors.append(delta_e_2000(spectra_to_xyz(transport * light), spectra_to_xyz(spectra), white))
    return np.concatenate(errors)


def test_five_wavelengths_serve_metals_under_spiky_light(layers, metals):
    errors = colour_errors(light_basis_plan(layers, metals, 5), layers, metals)
    assert errors.mean() < 0.15
    assert errors.max() < 0.8


def test_more_passes_are_better(layers, metals):
    means = [
        colour_errors(light_basis_plan(layers, metals, count), layers, metals).mean()
        for count in (2, 3, 5, 8)
    ]
    assert means == sorted(means, reverse=True)
    assert means[0] > 5 * means[-1]


def test_the_prediction_is_of_the_size_of_the_error(layers, metals):
    plan = light_basis_plan(layers, metals, 4)
    errors = colour_errors(plan, layers, metals)
    assert 0.3 < plan.predicted_de2000[0] / errors.mean() < 3.0


def test_chosen_wavelengths_beat_even_spacing(layers, metals):
    from spectral_probe.render.plan import _exchange, _expected_error, _lab_metric, _lights, _random_transport

    surfaces = np.concatenate([np.ones((1, 61)), metals])
    training = _random_transport(surfaces, 500, seed=5)
    covariance, metric = training.T @ training / 500 + 1e-6 * np.eye(61), _lab_metric(_lights(layers, None))
    even = list(range(6, 61, 12))
    exchanged = _exchange(even, covariance, metric)
    unpredicted = (covariance * metric).sum()  # what the error is counted from
    chosen, spaced = (_expected_error(nodes, covariance, metric) + unpredicted for nodes in (exchanged, even))
    assert 0 < chosen < 0.5 * spaced


def test_automatic_number_of_passes_reaches_its_target(layers, metals):
    plan = light_basis_plan(layers, metals)
    assert plan.predicted_de2000[0] <= TARGET_MEAN_DE2000
    assert plan.predicted_de2000[1] <= TARGET_MAX_DE2000
    assert plan.passes <= 6
    coloured = light_basis_plan(layers, np.concatenate([metals, surface_reflectances()]))
    assert coloured.passes > plan.passes


def test_a_scene_without_colours_needs_the_fewest_passes(layers):
    plan = light_basis_plan(layers, np.ones((1, 61)))
    assert plan.passes == 3
    assert plan.predicted_de2000[1] < 1e-6


def test_a_wrong_number_of_passes_is_refused(layers, metals):
    with pytest.raises(RenderError, match="choose a number from 1 to 61"):
        light_basis_plan(layers, metals, 99)


def test_files_give_back_the_plan_exactly(tmp_path, layers, metals):
    for plan in (light_basis_plan(layers, metals, 4), reference_plan()):
        save_plan(plan, tmp_path / "plan.json")
        read = load_plan(tmp_path / "plan.json")
        assert (read.kind, read.predicted_de2000) == (plan.kind, plan.predicted_de2000)
        for name in ("wavelengths_nm", "reconstruction", "grid_nm", "sample_shares"):
            np.testing.assert_array_equal(getattr(read, name), getattr(plan, name))
    assert [path.name for path in tmp_path.iterdir()] == ["plan.json"]


@pytest.mark.parametrize(
    "damage",
    [
        lambda content: content.pop("kind"),
        lambda content: content.update(kind="magic"),
        lambda content: content["wavelengths_nm"].pop(),
        lambda content: content.update(reconstruction="none"),
        lambda content: content.update(format="something else"),
    ],
)
def test_a_damaged_file_is_named(tmp_path, damage):
    path = tmp_path / "plan.json"
    save_plan(reference_plan(), path)
    content = json.loads(path.read_text())
    damage(content)
    path.write_text(json.dumps(content))
    with pytest.raises(FileFormatError, match=r"plan\.json is not a plan"):
        load_plan(path)


def test_a_missing_or_foreign_file_is_named(tmp_path):
    with pytest.raises(FileFormatError, match="cannot be read"):
        load_plan(tmp_path / "nothing.json")
    (tmp_path / "text.json").write_text("no JSON {")
    with pytest.raises(FileFormatError, match="is not a plan"):
        load_plan(tmp_path / "text.json")
