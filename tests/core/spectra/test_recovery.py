"""Spectral recovery (eq. 7-11): what comes back from camera responses, and how sure it is."""

import numpy as np
import pytest

from spectral_probe.errors import SpectralDataError
from spectral_probe.spectra.camera import camera_sensitivities
from spectral_probe.spectra.colorimetry import delta_e_2000, illuminant, spectra_to_xyz, white_xyz
from spectral_probe.spectra.confidence import Recovered, error_of_confidence
from spectral_probe.spectra.grid import STEP_NM, WAVELENGTHS_NM
from spectral_probe.spectra.incidence import incidence_cosines
from spectral_probe.spectra.library import FAMILIES as ALL_FAMILIES
from spectral_probe.spectra.library import daylight, planck, surface_reflectances, training_lights
from spectral_probe.spectra.metals import ball_reflectance
from spectral_probe.spectra.metrics import goodness_of_fit
from spectral_probe.spectra.recovery import spectral_recovery

CAMERA = camera_sensitivities("Nikon 5100 (NPL)")
FAMILIES = ("incandescent", "daylight")
GREEN_FILTER = np.exp(-0.5 * ((WAVELENGTHS_NM - 530) / 25) ** 2)


def seen(light, camera=CAMERA):
    """Responses of the camera to light."""
    return light @ camera * STEP_NM


def spectra_of(recovery, found):
    return np.einsum("...k,...kl->...l", found.weights, recovery.bases[found.basis_index])


def recovered(recovery, lights, direct=1.0):
    return spectra_of(recovery, recovery.recover(seen(lights, recovery.sensitivities), direct=direct))


def relative_error(estimate, truth):
    return np.linalg.norm(estimate - truth, axis=-1) / np.linalg.norm(truth, axis=-1)


def colour_difference(estimate, truth):
    xyz = [spectra_to_xyz(spectrum) for spectrum in (estimate, truth)]
    scale = 0.6 / xyz[1][..., 1:2]
    return delta_e_2000(xyz[0] * scale, xyz[1] * scale, white_xyz())


@pytest.mark.parametrize("cosine", [1.0, 0.7, 0.317, 0.05])
def test_the_papers_inversion_is_exact_in_its_span_at_any_incidence(cosine):
    recovery = spectral_recovery(CAMERA, FAMILIES, "paper")
    correction = recovery.incidence_correction(ball_reflectance("SUS304", incidence_cosines()))
    weights = np.array([3.0, -0.4, 0.2])
    in_ball = seen(weights @ recovery.bases[0] * ball_reflectance("SUS304", np.array(cosine)))
    found = recovery.recover(correction.light_responses(in_ball, np.array(cosine)))
    assert found.weights == pytest.approx(weights, rel=2e-3, abs=2e-3)


@pytest.mark.parametrize("material", ["SUS304", "silver", "aluminium", {"Cu": 1.0}])
def test_the_ball_is_divided_out_at_any_incidence(material):
    """Even of a copper ball, whose reflectance varies by a factor of two within the blue channel's neighbour."""
    recovery = spectral_recovery(CAMERA, FAMILIES)
    correction = recovery.incidence_correction(ball_reflectance(material, incidence_cosines()))
    lights = np.stack([planck(2730.0), planck(3140.0), daylight(5300), daylight(9870)])
    for cosine in (1.0, 0.6, 0.2):
        in_ball = seen(lights * ball_reflectance(material, np.array(cosine)))
        out = correction.light_responses(in_ball, np.full(len(lights), cosine))
        assert out == pytest.approx(seen(lights), rel=4e-3)


def test_noise_in_the_ball_is_noise_of_the_light():
    recovery = spectral_recovery(CAMERA, FAMILIES)
    correction = recovery.incidence_correction(ball_reflectance("SUS304", incidence_cosines()))
    rng = np.random.default_rng(4)
    responses = 1.0 + rng.normal(scale=0.01, size=(20000, 3))
    cosines = np.full(20000, 0.5)
    stated = correction.light_variance(np.full((20000, 3), 1e-4), cosines)[0]
    assert correction.light_responses(responses, cosines).var(0) == pytest.approx(stated, rel=0.05)


@pytest.mark.parametrize(
    "light", [planck(2730.0), planck(3140.0), daylight(5300), daylight(6870), daylight(11000)]
)
def test_lights_of_the_families_that_were_not_trained_on(light):
    estimate = recovered(spectral_recovery(CAMERA, FAMILIES), light)
    assert goodness_of_fit(estimate, light) > 0.9993
    assert colour_difference(estimate, light) < 0.25


def test_reflected_light_is_recovered_better_than_by_the_lights_own_components():
    lights = np.stack([planck(2850.0), daylight(6100)])
    reflected = (lights[:, None] * surface_reflectances()).reshape(-1, 61)
    fits = {
        method: np.median(
            goodness_of_fit(recovered(spectral_recovery(CAMERA, FAMILIES, method), reflected, 0.1), reflected)
        )
        for method in ("family", "paper")
    }
    assert fits["family"] > 0.99
    assert fits["family"] > fits["paper"]


def test_brightness_tells_a_lamp_from_a_wall():
    """The same responses are a lamp's if it is bright, and may be a coloured wall's if it is not."""
    recovery = spectral_recovery(CAMERA, FAMILIES)
    lamp = planck(2850.0)
    as_lamp = relative_error(recovered(recovery, lamp, 0.98), lamp)
    as_wall = relative_error(recovered(recovery, lamp, 0.02), lamp)
    assert as_lamp < as_wall
    walls = (np.stack([lamp, daylight(6100)])[:, None] * surface_reflectances()).reshape(-1, 61)
    errors = [relative_error(recovered(recovery, walls, direct), walls).mean() for direct in (0.02, 1.0)]
    assert errors[0] < 0.8 * errors[1]


@pytest.mark.parametrize("families", [FAMILIES, ("automatic",), ("led-rgb",), ("discharge",)])
@pytest.mark.parametrize("filters", [0, 1])
def test_spectra_are_never_negative(families, filters):
    rng = np.random.default_rng(8)
    camera = np.concatenate([CAMERA] + [CAMERA * GREEN_FILTER[:, None]] * filters, axis=1)
    responses = np.exp(rng.normal(scale=1.5, size=(4000, camera.shape[1])))  # more colourful than any light
    recovery = spectral_recovery(camera, families)
    found = recovery.recover(responses.astype(np.float32), direct=rng.uniform(0.02, 0.98, 4000))
    assert spectra_of(recovery, found).min() >= 0
    assert found.weights.dtype == np.float32


def test_the_papers_method_leaves_negative_spectra():
    responses = np.exp(np.random.default_rng(8).normal(scale=1.5, size=(4000, 3)))
    paper = spectral_recovery(CAMERA, FAMILIES, "paper")
    assert spectra_of(paper, paper.recover(responses)).min() < 0
    assert paper.bases.shape == (1, 3, 61)


def test_making_a_spectrum_positive_leaves_the_others_alone():
    family = spectral_recovery(CAMERA, FAMILIES)
    lamp = seen(illuminant("A"))
    alone = family.recover(lamp[None]).weights
    beside = family.recover(np.stack([lamp, [1.0, 50.0, 1.0]])).weights
    assert np.array_equal(alone[0], beside[0])


def test_level_does_not_matter():
    recovery = spectral_recovery(CAMERA, ["automatic"])
    responses = seen(training_lights(["fluorescent-triband"]))
    one, many = recovery.recover(responses), recovery.recover(1e6 * responses)
    assert many.weights == pytest.approx(
        1e6 * one.weights, rel=1e-3, abs=1e-3 * float(np.abs(many.weights).max())
    )
    assert np.array_equal(one.basis_index, many.basis_index)


def test_the_kind_of_light_is_told_where_it_can_be():
    recovery = spectral_recovery(CAMERA, FAMILIES)
    names = [estimate.name for estimate in recovery.estimates]
    likely = recovery.probabilities(seen(np.stack([planck(2700.0), daylight(6500)])))
    assert likely.sum(-1) == pytest.approx(1)
    assert [names[index] for index in likely.argmax(-1)] == ["incandescent", "daylight"]


def test_filtered_channels_tell_fluorescent_lamps_apart():
    with_filter = np.concatenate([CAMERA, CAMERA * GREEN_FILTER[:, None]], axis=1)
    lights = training_lights(["fluorescent-halophosphate"])
    fits = [
        goodness_of_fit(recovered(spectral_recovery(camera, ["automatic"]), lights), lights).mean()
        for camera in (CAMERA, with_filter)
    ]
    assert fits[1] > fits[0] + 0.02
    assert fits[1] > 0.985


def test_stated_error_is_the_error():
    """The stated relative error agrees with the actual one, over lights and over reflected lights of the families."""
    recovery = spectral_recovery(CAMERA, FAMILIES)
    lights = np.stack(
        [planck(k) for k in (2450, 2850, 3250)] + [daylight(k) for k in (4600, 5600, 6600, 9500)]
    )
    reflected = (lights[:, None] * surface_reflectances()).reshape(-1, 61)
    for spectra, direct in ((lights, 1.0), (reflected, 0.05)):
        found = recovery.recover(seen(spectra), direct=direct)
        actual = relative_error(spectra_of(recovery, found), spectra)
        stated = found.relative_error
        # more is stated than these smooth lights need: the families have stranger members, each tried as if it were new
        assert 0.7 < np.sqrt((stated**2).mean()) / np.sqrt((actual**2).mean()) < 5


def test_confidence_falls_with_noise_and_with_strange_lights():
    recovery = spectral_recovery(CAMERA, FAMILIES)
    filament, laser = seen(illuminant("A")), seen(np.eye(61)[20])
    usual = recovery.recover(filament, np.zeros(3))
    noisy = recovery.recover(filament, (0.2 * filament) ** 2)
    strange = recovery.recover(laser, np.zeros(3))
    assert 0.9 < usual.confidence <= 1
    assert noisy.confidence < usual.confidence
    assert strange.confidence < 0.5
    assert error_of_confidence(float(usual.confidence)) == pytest.approx(
        float(usual.relative_error), rel=1e-3
    )


def test_confidence_is_one_half_at_an_error_of_one_half():
    found = Recovered(np.zeros((1, 3)), np.zeros(1, np.uint8), np.array([0.5]))
    assert found.confidence == pytest.approx(0.5)


def test_every_family_can_be_recovered_from():
    for families in [[family] for family in ALL_FAMILIES] + [["fluorescent-triband", "daylight"]]:
        recovery = spectral_recovery(CAMERA, families)
        estimate = recovered(recovery, training_lights(families))
        assert estimate.min() >= 0
        assert goodness_of_fit(estimate, training_lights(families)).mean() > 0.85


def test_a_measured_light_of_the_users_own_comes_back():
    own = np.exp(-0.5 * ((WAVELENGTHS_NM - 470) / 12) ** 2) + 0.7 * np.exp(
        -0.5 * ((WAVELENGTHS_NM - 640) / 15) ** 2
    )
    without = recovered(spectral_recovery(CAMERA, FAMILIES), own)
    with_it = recovered(spectral_recovery(CAMERA, FAMILIES, own_lights=own[None]), own)
    assert goodness_of_fit(with_it, own) > 0.97 > goodness_of_fit(without, own) + 0.1


def test_unknown_words_are_explained():
    with pytest.raises(SpectralDataError, match='Did you mean "incandescent"'):
        spectral_recovery(CAMERA, ["incandecent"])
    with pytest.raises(SpectralDataError, match="no recovery method"):
        spectral_recovery(CAMERA, FAMILIES, "magic")
    with pytest.raises(SpectralDataError, match="at least one lamp family"):
        spectral_recovery(CAMERA, [])


def test_equal_channels_are_refused():
    alike = np.stack([CAMERA[:, 0], CAMERA[:, 1], 2 * CAMERA[:, 1]], axis=1)
    with pytest.raises(SpectralDataError, match="see the same light"):
        spectral_recovery(alike, FAMILIES)
