import numpy as np
import pytest

from spectral_probe.errors import SpectralDataError
from spectral_probe.spectra.basis import principal_components, prior_covariance
from spectral_probe.spectra.camera import camera_sensitivities
from spectral_probe.spectra.colorimetry import delta_e_2000, illuminant, spectra_to_xyz, white_xyz
from spectral_probe.spectra.grid import STEP_NM
from spectral_probe.spectra.library import daylight, planck, surface_reflectances, training_lights
from spectral_probe.spectra.metals import ball_reflectance
from spectral_probe.spectra.metrics import goodness_of_fit
from spectral_probe.spectra.recovery import error_of_confidence, spectral_recovery

CAMERA = camera_sensitivities("Nikon 5100 (NPL)")
FAMILIES = ("incandescent", "daylight")


def seen(light, cosine):
    """Responses of the camera to light mirrored by a steel ball."""
    return (light * ball_reflectance("SUS304", np.asarray(cosine))) @ CAMERA * STEP_NM


def colour_difference(estimate, truth):
    xyz = [spectra_to_xyz(spectrum) for spectrum in (estimate, truth)]
    scale = 0.6 / xyz[1][..., 1:2]
    return delta_e_2000(xyz[0] * scale, xyz[1] * scale, white_xyz())


@pytest.mark.parametrize("cosine", [1.0, 0.7, 0.317, 0.05])
def test_a_light_in_the_span_comes_back_exactly_at_any_incidence(cosine):
    recovery = spectral_recovery(CAMERA, "SUS304", FAMILIES, "paper")
    weights = np.array([3.0, -0.4, 0.2])
    found = recovery.weights(seen(weights @ recovery.basis, cosine), np.array(cosine))
    assert found == pytest.approx(weights, rel=2e-3, abs=2e-3)


@pytest.mark.parametrize(
    "light", [planck(2730.0), planck(3140.0), daylight(5300), daylight(6870), daylight(11000)]
)
def test_lights_of_the_families_that_were_not_trained_on(light):
    recovery = spectral_recovery(CAMERA, "SUS304", FAMILIES)
    estimate = recovery.weights(seen(light, 0.6), np.array(0.6)) @ recovery.basis
    assert goodness_of_fit(estimate, light) > 0.998
    assert colour_difference(estimate, light) < 0.5


def test_reflected_light_is_recovered_better_than_by_the_lights_own_components():
    lights = np.stack([planck(2850.0), daylight(6100)])
    reflected = (lights[:, None] * surface_reflectances()).reshape(-1, 61)
    cosine = np.full(len(reflected), 0.8)
    fits = {}
    for method in ("family", "paper"):
        recovery = spectral_recovery(CAMERA, "SUS304", FAMILIES, method)
        estimate = recovery.weights(seen(reflected, cosine), cosine) @ recovery.basis
        fits[method] = np.median(goodness_of_fit(estimate, reflected))
    assert fits["family"] > 0.99
    assert fits["family"] > fits["paper"]


def test_spectra_are_never_negative_but_in_the_papers_method():
    rng = np.random.default_rng(8)
    responses = np.exp(rng.normal(scale=1.5, size=(4000, 3)))  # far more colourful than any light
    cosine = rng.uniform(0.1, 1, 4000)
    family = spectral_recovery(CAMERA, "SUS304", FAMILIES)
    spectra = family.non_negative(family.weights(responses, cosine)) @ family.basis
    assert spectra.min() >= -1e-6 * spectra.max()
    paper = spectral_recovery(CAMERA, "SUS304", FAMILIES, "paper")
    assert (paper.non_negative(paper.weights(responses, cosine)) @ paper.basis).min() < 0


def test_moving_a_spectrum_off_the_negative_leaves_the_others_alone():
    family = spectral_recovery(CAMERA, "SUS304", FAMILIES)
    weights = family.weights(np.stack([seen(illuminant("A"), 0.5), [1.0, 50.0, 1.0]]), np.array([0.5, 0.5]))
    moved = family.non_negative(weights)
    assert np.allclose(moved[0], weights[0])
    assert not np.allclose(moved[1], weights[1])


def test_predicted_error_is_the_error():
    """The stated relative error agrees with the actual one over lights and reflected lights of the families."""
    recovery = spectral_recovery(CAMERA, "SUS304", FAMILIES)
    lights = np.stack(
        [planck(k) for k in (2450, 2850, 3250)] + [daylight(k) for k in (4600, 5600, 6600, 9500)]
    )
    spectra = np.concatenate([lights, (lights[:, None] * surface_reflectances()).reshape(-1, 61)])
    cosine = np.full(len(spectra), 0.8)
    weights = recovery.weights(seen(spectra, cosine), cosine)
    stated = recovery.relative_error(weights, np.zeros_like(weights), cosine)
    actual = np.linalg.norm(weights @ recovery.basis - spectra, axis=-1) / np.linalg.norm(spectra, axis=-1)
    assert np.sqrt((stated**2).mean()) == pytest.approx(np.sqrt((actual**2).mean()), rel=0.5)


def test_confidence_falls_with_noise_and_with_strange_lights():
    recovery = spectral_recovery(CAMERA, "SUS304", FAMILIES)
    cosine = np.array(0.7)
    quiet = np.zeros(3)
    filament = seen(illuminant("A"), cosine)
    laser = seen(np.eye(61)[20], cosine)
    usual = recovery.confidence(recovery.weights(filament, cosine), quiet, cosine)
    noisy = recovery.confidence(recovery.weights(filament, cosine), (0.2 * filament) ** 2, cosine)
    strange = recovery.confidence(recovery.weights(laser, cosine), quiet, cosine)
    assert 0.9 < usual <= 1
    assert noisy < usual
    assert strange < usual
    assert recovery.relative_error(recovery.weights(filament, cosine), quiet, cosine) == pytest.approx(
        error_of_confidence(float(usual)), rel=1e-3
    )


def test_principal_components_span_the_training_set():
    lights = training_lights(FAMILIES)
    basis = principal_components(lights, 3)
    residual = np.linalg.norm(lights - lights @ basis.T @ basis, axis=-1) / np.linalg.norm(lights, axis=-1)
    assert np.median(residual) < 0.02
    worse = principal_components(lights, 2)
    assert (
        residual.mean()
        < 0.5
        * (
            np.linalg.norm(lights - lights @ worse.T @ worse, axis=-1) / np.linalg.norm(lights, axis=-1)
        ).mean()
    )


def test_families_count_alike():
    both = prior_covariance(FAMILIES)
    assert np.allclose(both, (prior_covariance(["incandescent"]) + prior_covariance(["daylight"])) / 2)
    assert np.trace(both) == pytest.approx(1)


def test_every_family_can_be_recovered_from():
    for families in (["automatic"], ["led-rgb"], ["discharge"], ["fluorescent-triband", "daylight"]):
        recovery = spectral_recovery(CAMERA, "SUS304", families)
        weights = recovery.weights(seen(training_lights(families), 0.8), np.array(0.8))
        spectra = recovery.non_negative(weights) @ recovery.basis
        assert spectra.min() >= -1e-6 * spectra.max()


def test_unknown_words_are_explained():
    with pytest.raises(SpectralDataError, match='Did you mean "incandescent"'):
        spectral_recovery(CAMERA, "SUS304", ["incandecent"])
    with pytest.raises(SpectralDataError, match="no recovery method"):
        spectral_recovery(CAMERA, "SUS304", FAMILIES, "magic")
    with pytest.raises(SpectralDataError, match="at least one lamp family"):
        spectral_recovery(CAMERA, "SUS304", [])
