"""Plans of passes: the reference, light-basis plans, fitted wavelengths."""

import numpy as np
import pytest

from spectral_probe.errors import RenderError
from spectral_probe.model import SpectralPanorama
from spectral_probe.render.interpolation import (
    NodeChoice,
    interpolation_weights,
    lab_metric,
    random_products,
    second_moment,
)
from spectral_probe.render.light_sets import light_sets
from spectral_probe.render.plan import describe, make_plan, reference_plan, wavelength_plan
from spectral_probe.render.quadrature import balanced
from spectral_probe.render_model import EmissionGroup
from spectral_probe.spectra.colorimetry import delta_e_2000, illuminant, spectra_to_xyz, white_xyz
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.library import planck, surface_reflectances
from spectral_probe.spectra.metals import metal_reflectance

ANGLES = np.cos(np.radians([0.0, 30.0, 60.0, 80.0]))


@pytest.fixture(scope="module")
def metals():
    return np.concatenate([metal_reflectance(metal, ANGLES) for metal in ("Au", "Ag", "Cu")])


def panorama_of(spectra, seed=0):
    """Mixtures of some lights, another in every direction."""
    size = (12, 24)
    return SpectralPanorama(
        weights=np.random.default_rng(seed)
        .dirichlet(np.full(len(spectra), 0.4), size=size)
        .astype(np.float32),
        bases=np.asarray(spectra, float)[None],
        basis_index=np.zeros(size, np.uint8),
        wavelengths_nm=WAVELENGTHS_NM.copy(),
        valid=np.ones(size, bool),
        confidence=np.ones(size, np.float32),
    )


@pytest.fixture(scope="module")
def lights():
    """Filament light, daylight, and a tube with mercury lines."""
    return np.stack([planck(2856.0), illuminant("D65") / 100, illuminant("FL2") / 10])


@pytest.fixture(scope="module")
def planned(lights):
    """A function that plans for surfaces in these lights; gives the sets and the plan."""
    panorama = panorama_of(lights)

    def plan(surfaces, panorama=panorama, max_de2000=0.5, **words):
        sets = light_sets(panorama, reflectances=surfaces, max_de2000=max_de2000)
        return sets, make_plan(sets, panorama, surfaces, max_de2000=max_de2000, **words)

    return plan


def test_the_reference_holds_each_wavelength_once():
    plan = reference_plan()
    assert plan.passes == 21
    spectrum = np.random.default_rng(0).random(61)
    passes = np.interp(plan.wavelengths_nm, WAVELENGTHS_NM, spectrum)
    np.testing.assert_allclose(np.einsum("pc,pcl->l", passes, plan.reconstruction), spectrum, atol=1e-15)
    assert (plan.reconstruction.sum(2) == 0).sum() == 2  # the padding channels


def test_the_reference_pairs_distant_wavelengths(planned, metals):
    spread = np.ptp(reference_plan().wavelengths_nm[:18], axis=1)
    assert spread.min() > 150
    assert planned(metals, passes="all")[1].predicted_cost == 21.0


@pytest.mark.parametrize("passes", [1, 3, 5, 9])
def test_constants_and_nodes_are_exact(planned, metals, passes):
    (light,), plan = planned(metals, passes=passes)
    layers = light.layers.spectra
    assert plan.passes == passes
    assert (plan.wavelengths_nm == plan.wavelengths_nm[:, :1]).all()
    np.testing.assert_allclose(plan.interpolation.sum(0), 1.0, rtol=1e-9)
    np.testing.assert_allclose(plan.reconstruction.sum(0), layers, rtol=1e-9)
    nodes = np.searchsorted(WAVELENGTHS_NM, plan.wavelengths_nm[:, 0])
    np.testing.assert_allclose(plan.interpolation[:, nodes], np.eye(passes), atol=1e-9)


def colour_errors(light, plan, panorama, metals):
    """DE2000 over every product of two of the metals' reflectances in the light of some directions, of luminance 1 in D65.

    Not what the planner predicts with: white is each light's own luminance.
    """
    transport = (metals[:, None] * metals[None]).reshape(-1, 61)
    nodes = np.searchsorted(WAVELENGTHS_NM, plan.wavelengths_nm[:, 0])
    errors = []
    for row, column in ((0, 0), (3, 7), (6, 12), (11, 20)):
        true = panorama.weights[row, column].astype(float) @ panorama.bases[0]
        held = light.layers.weights[row, column].astype(float)
        spectra = np.einsum("tp,c,pcl->tl", transport[:, nodes], held, plan.reconstruction)
        white = white_xyz() * spectra_to_xyz(true)[1]
        errors.append(delta_e_2000(spectra_to_xyz(transport * true), spectra_to_xyz(spectra), white))
    return np.concatenate(errors)


def test_more_passes_are_better_and_the_prediction_is_of_the_size_of_the_error(planned, lights, metals):
    panorama, means = panorama_of(lights), []
    for count in (2, 3, 5, 8):
        (light,), plan = planned(metals, passes=count)
        errors = colour_errors(light, plan, panorama, metals)
        means.append(errors.mean())
        assert 0.3 < plan.predicted_de2000[0] / errors.mean() < 3.0
        assert errors.max() < 2 * plan.predicted_de2000[1]
    assert means == sorted(means, reverse=True)
    assert means[0] > 5 * means[-1]


def test_chosen_wavelengths_beat_even_spacing(metals, lights):
    surfaces = np.concatenate([np.ones((1, 61)), metals])
    choice = NodeChoice(second_moment(random_products(surfaces, 500, seed=5)), lab_metric(lights))
    assert 0 < choice.expected_error(choice.nodes(5)) < 0.5 * choice.expected_error(list(range(6, 61, 12)))


def test_expected_error_is_that_of_the_interpolation(metals, lights):
    """The error found step by step is that of the weights found at once, on the very samples."""
    samples = random_products(metals, 400, seed=3)
    moment, metric = samples.T @ samples / len(samples), lab_metric(lights)
    choice, nodes = NodeChoice(moment, metric), [4, 22, 40]
    weights = interpolation_weights(nodes, moment)
    left = samples - samples[:, nodes] @ weights
    np.testing.assert_allclose(
        choice.expected_error(nodes), np.einsum("nl,lm,nm->n", left, metric, left).mean(), rtol=1e-6
    )


def test_automatic_number_of_passes_keeps_its_bound_and_is_the_smallest(planned, metals):
    _, plan = planned(metals)
    assert plan.predicted_de2000[1] <= 0.5
    assert plan.passes <= 7
    _, strict = planned(metals, max_de2000=0.1)
    assert strict.passes > plan.passes
    _, coloured = planned(np.concatenate([metals, surface_reflectances()]))
    assert coloured.passes > plan.passes
    _, fewer = planned(metals, passes=plan.passes - 1)
    assert plan.passes == 3 or fewer.predicted_de2000[1] > 0.5


def test_a_scene_without_colours_needs_the_fewest_passes(planned):
    _, plan = planned(np.ones((1, 61)))
    assert plan.passes == 3
    assert plan.predicted_de2000[1] < 1e-3


def test_cost_is_of_the_samples_of_all_passes(planned, metals):
    _, plan = planned(metals, passes=5, samples=128)
    assert plan.predicted_cost == 1 + 4 * 8 / 128
    assert set(plan.references) == {int(np.argmax(plan.sample_shares))}
    assert 520 <= plan.wavelengths_nm[plan.references[0], 0] <= 600  # where it is bright
    _, few = planned(metals, passes=5, samples=16)
    assert few.predicted_cost == 1 + 4 * 4 / 16  # four samples at least
    _, full = planned(metals, passes=5, samples=16, full_samples=True)
    assert full.predicted_cost == 5
    assert full.references == (0, 1, 2, 3, 4)


@pytest.fixture(scope="module")
def fitted(metals, lights):
    """A wavelength plan for metals in these lights."""
    return wavelength_plan(panorama_of(lights), metals)


def test_fitted_wavelengths_share_the_samples_of_one_render(fitted, metals, lights):
    assert fitted.kind == "wavelength"
    assert fitted.predicted_cost == 1.0
    assert fitted.predicted_de2000[1] <= 0.5
    assert fitted.consecutive
    np.testing.assert_allclose(fitted.sample_shares.sum(), 1.0)
    full = wavelength_plan(panorama_of(lights), metals, full_samples=True)
    assert full.predicted_cost == full.passes
    assert full.passes <= fitted.passes


def test_few_samples_leave_no_room_for_many_passes(metals, lights):
    assert wavelength_plan(panorama_of(lights), metals, max_de2000=0.05, samples=4) is None


def test_a_dispersive_glass_is_rendered_at_all_wavelengths(metals, lights):
    plan = wavelength_plan(panorama_of(lights), metals, dispersive=True)
    assert len(np.unique(plan.wavelengths_nm)) == 61
    assert plan.predicted_cost == 1.0


def test_wavelengths_are_dealt_so_that_passes_are_alike():
    """No exchange of two wavelengths makes the passes more alike, and dealt by size they are far less so."""
    contributions = np.random.default_rng(8).random((200, 12, 3))

    def unlike(passes):
        return sum((contributions[:, own].sum(1) ** 2).sum() for own in passes)

    dealt = balanced(contributions)
    assert sorted(dealt.ravel().tolist()) == list(range(12))
    for first in range(12):
        for second in range(first):
            trade = np.arange(12)
            trade[[first, second]] = trade[[second, first]]
            assert unlike(trade[dealt]) >= unlike(dealt) - 1e-9
    order = np.argsort(contributions.sum((0, 2)))
    assert unlike(order.reshape(4, 3)) > 1.001 * unlike(dealt)


def test_dealt_wavelengths_make_less_noise_of_colours(fitted, metals, lights):
    """Against wavelengths that are neighbours: the noise of one pass is then the noise of one colour."""
    spectra = np.concatenate([metals * light for light in lights])
    dealt = np.searchsorted(WAVELENGTHS_NM, fitted.wavelengths_nm)
    coefficients = spectra_to_xyz(fitted.reconstruction).reshape(-1, 3)
    parts = spectra[:, dealt.ravel(), None] * (coefficients / white_xyz())
    relative = parts / parts[..., 1].sum(1)[:, None, None]
    order = np.argsort(dealt.ravel())
    own, neighbours = (
        np.var(relative[:, passes.reshape(-1, 3)].sum(2), axis=1).sum()
        for passes in (np.arange(order.size), order)
    )
    assert own < 0.5 * neighbours


def test_fitted_wavelengths_reproduce_colours(fitted, metals):
    light = planck(3000.0) + illuminant("FL2") / 10  # tungsten of another temperature: not among those fitted
    exact = (
        np.concatenate([metals[:, None] * metals[None], metals[None, :, None][0]], 1).reshape(-1, 61) * light
    )
    index = np.searchsorted(WAVELENGTHS_NM, fitted.wavelengths_nm)
    estimate = np.einsum("npc,pcl->nl", exact[:, index], fitted.reconstruction)
    white = white_xyz() * spectra_to_xyz(light)[1]
    errors = delta_e_2000(spectra_to_xyz(exact), np.maximum(spectra_to_xyz(estimate), 0), white)
    assert errors.mean() < 0.5


def test_emission_is_predicted_too_and_rides_with_set_0(planned, metals):
    """A lamp of spikes beside smooth light needs more wavelengths than the smooth light alone."""
    lamp = EmissionGroup(
        "lamps 1", np.stack([illuminant("LPS") / 10, np.zeros(61), np.zeros(61)]), ("hall", "", "")
    )
    _, without = planned(metals, passes=3)
    _, plan = planned(metals, passes=3, emission=(lamp,))
    assert plan.emission == (lamp,)
    assert plan.predicted_de2000 != without.predicted_de2000
    assert set(plan.light_sets) == {0}


def test_a_bound_out_of_reach_is_said(planned, metals):
    _, plan = planned(metals, max_de2000=1e-5)
    assert any("is not reached" in sentence for sentence in describe(plan))


@pytest.mark.parametrize("passes", [0, 99])
def test_a_wrong_number_of_passes_is_refused(planned, metals, passes):
    with pytest.raises(RenderError, match="choose a number from 1 to 61"):
        planned(metals, passes=passes)
