"""Gains and the ball's reflectance from one known light: wrong gains, wrong balls and wrong scales come back."""

import numpy as np
import pytest

from spectral_probe.errors import SpectralDataError
from spectral_probe.spectra.calibration import ball_correction, channel_gains
from spectral_probe.spectra.camera import camera_sensitivities
from spectral_probe.spectra.colorimetry import illuminant
from spectral_probe.spectra.grid import STEP_NM, WAVELENGTHS_NM
from spectral_probe.spectra.metals import ball_reflectance, fresnel_reflectance
from spectral_probe.spectra.recovery import spectral_recovery

NIKON = camera_sensitivities("Nikon 5100 (NPL)")
LIGHTS = ("A", "D65", "FL2", "FL11")


def cosine(degrees):
    return np.cos(np.radians(np.asarray(degrees, float)))


@pytest.mark.parametrize("name", LIGHTS)
def test_gains_lost_by_normalising_per_channel_come_back(name):
    """A camera whose channels answer 1 : 2.1 : 1.4, published with every curve at a peak of 1; a card under a known light."""
    truth = np.array([1.0, 2.1, 1.4])
    published = NIKON / NIKON.max(0)
    card = 0.18 * illuminant(name)
    noise = 1 + 0.001 * np.random.default_rng(0).standard_normal(3)
    gains = channel_gains(card @ (published * truth) * STEP_NM * noise, card, published)
    np.testing.assert_allclose(gains, truth[1] / truth, rtol=0.005)
    assert gains[1] == 1.0


def test_a_lamp_in_the_ball_calibrates_as_well():
    published = NIKON / NIKON.max(0)
    mirrored = illuminant("A") * ball_reflectance("SUS304", cosine(40))
    gains = channel_gains(mirrored @ (published * [0.5, 1.0, 0.8]) * 7.0, mirrored, published)
    np.testing.assert_allclose(gains, [2.0, 1.0, 1.25], rtol=1e-9)


def test_an_absolute_spectrum_gives_recovered_spectra_its_scale():
    """With sensitivities divided by the gains, another light comes out in the unit of the known one, within 1 %."""
    counts_per_radiance = np.array([310.0, 655.0, 402.0])
    known, other = 0.012 * illuminant("A"), 0.0031 * illuminant("D65")
    published = NIKON / NIKON.max(0)
    gains = channel_gains(known @ (published * counts_per_radiance), known, published, absolute=True)
    recovery = spectral_recovery(published / gains, ["daylight"])
    recovered = recovery.recover(other @ (published * counts_per_radiance))
    found = recovered.weights @ recovery.bases[recovered.basis_index]
    assert found.sum() == pytest.approx(other.sum(), rel=0.01)
    assert np.linalg.norm(found - other) < 0.02 * np.linalg.norm(other)


@pytest.fixture(scope="module")
def steel(shared_dir):
    """Reflectance of measured austenitic steel by the cosine of incidence (Karlsson & Ribbing 1982)."""
    path = shared_dir / "spectra/metals/stainless_austenitic_Karlsson.csv"
    rows = [line.split(",")[:3] for line in path.read_text().splitlines() if line[:1].isdigit()]
    nm, n, k = np.array(rows, float).T
    n, k = np.interp(WAVELENGTHS_NM, nm, n), np.interp(WAVELENGTHS_NM, nm, k)
    return lambda cos: fresnel_reflectance(n, k, np.asarray(cos)[..., None])


def cameras(shared_dir):
    files = sorted((shared_dir / "spectra/cameras").glob("*.csv"))
    return [NIKON, *(camera_sensitivities(None, file) for file in files)]


@pytest.mark.parametrize("name", LIGHTS)
@pytest.mark.parametrize("incidence_deg", [10, 30, 45])
def test_steel_modelled_too_dark_is_found(steel, shared_dir, name, incidence_deg):
    """Eq. 11 makes it 1.21 times too dark: with any camera, right within 2 % near the angle seen and within 4 % up to 60."""
    angles = cosine([incidence_deg, 0, 20, 45, 60])
    modelled, card = ball_reflectance("SUS304", angles), 0.18 * illuminant(name)
    truth = steel(angles)
    assert truth[0].mean() / modelled[0].mean() > 1.18
    for camera in cameras(shared_dir):
        unknown_gains = camera * [0.7, 1.0, 1.3]
        correction = ball_correction(
            (card * truth[0]) @ unknown_gains, card @ unknown_gains, card, camera, modelled[0]
        )
        error = np.abs(correction.applied(modelled) / truth - 1).max(-1)
        assert (error < [0.02, 0.02, 0.02, 0.02, 0.04]).all()
        assert not correction.exceeds


def test_channels_are_reproduced_exactly_and_noise_is_not_blown_up():
    modelled, card = ball_reflectance("SUS304", cosine(20)), illuminant("A")
    ratio = np.array([0.66, 0.64, 0.60])
    correction = ball_correction(ratio, np.ones(3), card, NIKON, modelled)
    seen = (card * modelled * correction.factor) @ NIKON / (card @ NIKON)
    np.testing.assert_allclose(seen, ratio, rtol=1e-9)
    noisy = ball_correction(ratio * [1.005, 1.0, 0.995], np.ones(3), card, NIKON, modelled)
    assert np.abs(noisy.factor / correction.factor - 1).max() < 0.02


def test_a_dusty_ball_is_darker_at_every_angle_and_nothing_exceeds_one():
    angles = cosine([20, 70, 89.9])
    modelled, card = ball_reflectance("chrome", angles), illuminant("D65")
    dusty = ball_correction((0.8 * card * modelled[0]) @ NIKON, card @ NIKON, card, NIKON, modelled[0])
    np.testing.assert_allclose(dusty.applied(modelled), 0.8 * modelled, rtol=1e-6)
    bright = ball_correction((1.3 * card * modelled[0]) @ NIKON, card @ NIKON, card, NIKON, modelled[0])
    assert bright.applied(modelled).max() <= 1.0
    assert bright.applied(modelled)[-1].min() > 0.99  # grazing incidence reflects everything


def test_a_ball_brighter_than_the_card_is_said_to_be():
    card, modelled = illuminant("A"), ball_reflectance("silver", cosine(20))
    correction = ball_correction(np.full(3, 1.1), np.ones(3), card, NIKON, modelled)
    assert correction.exceeds
    assert correction.applied(modelled).max() <= 1.0 + 1e-9


def test_what_cannot_be_is_refused():
    lamp = illuminant("A")
    for measured, light in (([0.0, 1, 1], lamp), ([1, np.nan, 1], lamp), ([1, 1, 1], np.zeros(61))):
        with pytest.raises(SpectralDataError, match="a channel does not see the light"):
            channel_gains(np.array(measured), light, NIKON)
    modelled = ball_reflectance("SUS304", cosine(20))
    with pytest.raises(SpectralDataError, match="black in a channel"):
        ball_correction(np.array([0.0, 1, 1]), np.ones(3), lamp, NIKON, modelled)
    with pytest.raises(SpectralDataError, match="no smooth reflectance does that"):
        ball_correction(np.array([0.9, 0.01, 0.9]), np.ones(3), lamp, NIKON, modelled)
