"""Light layers: exact where three suffice, non-negative always, honest about what is lost."""

import numpy as np
import pytest

from spectral_probe.errors import RenderError
from spectral_probe.model import SpectralPanorama
from spectral_probe.render.layers import colour_error, light_layers
from spectral_probe.spectra.colorimetry import delta_e_2000, illuminant, spectra_to_xyz, white_xyz
from spectral_probe.spectra.glass import glass_transmittance
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.library import daylight, planck, training_lights

H, W = 24, 48


def panorama(weights, bases, index=None):
    bases = np.asarray(bases, float)
    return SpectralPanorama(
        weights=np.asarray(weights, np.float32),
        bases=bases if bases.ndim == 3 else bases[None],
        basis_index=np.zeros((H, W), np.uint8) if index is None else index.astype(np.uint8),
        wavelengths_nm=WAVELENGTHS_NM.copy(),
        valid=np.ones((H, W), bool),
        confidence=np.ones((H, W), np.float32),
    )


def spectra_of(probe):
    return np.einsum("hwk,hwkl->hwl", probe.weights.astype(float), probe.bases[probe.basis_index])


@pytest.fixture
def generator():
    return np.random.default_rng(7)


def pca_panorama(generator):
    """Mixtures of filament light and daylight in a signed basis of three components, as recovery makes them."""
    lights = training_lights(["incandescent", "daylight"])
    basis = np.linalg.svd(lights, full_matrices=False)[2][:3]
    mixtures = generator.dirichlet(np.full(len(lights), 0.05), size=(H, W)) @ lights
    level = generator.lognormal(0.0, 2.0, size=(H, W, 1))
    return panorama(level * (mixtures @ basis.T), basis)


def test_three_weights_are_exact(generator):
    probe = pca_panorama(generator)
    assert probe.weights.min() < 0  # the basis is signed: the layers are not simply the weights
    layers = light_layers(probe)
    assert layers.weights.min() >= 0
    assert layers.residual < 1e-6
    spectra = spectra_of(probe)
    error = np.abs(layers.weights @ layers.spectra - spectra).max(-1) / spectra.max(-1)
    lit = spectra.sum(-1) > 1e-3 * spectra.sum(-1).mean()
    assert error[lit].max() < 1e-4


def test_the_cone_is_tight(generator):
    """In a tight cone no layer is idle: each has texels that hold none of it, and texels that hold much of it."""
    layers = light_layers(pca_panorama(generator))
    share = layers.weights / np.maximum(layers.weights.sum(-1, keepdims=True), 1e-9)
    assert (share.min((0, 1)) < 0.02).all()
    assert (share.max((0, 1)) > 0.4).all()


def test_layers_do_not_depend_on_the_unit(generator):
    probe = pca_panorama(generator)
    scaled = panorama(probe.weights * 1e4, probe.bases)
    one, other = light_layers(probe), light_layers(scaled)
    np.testing.assert_allclose(one.weights, other.weights, rtol=1e-3, atol=1e-4)
    np.testing.assert_allclose(one.spectra * 1e4, other.spectra, rtol=1e-3, atol=1e-3 * other.spectra.max())
    assert 0.1 < one.weights.mean() < 3


def test_one_colour_of_light_works():
    layers = light_layers(panorama(np.ones((H, W, 1)), planck(2856.0)[None]))
    expected = np.broadcast_to(planck(2856.0), (H, W, 61))
    np.testing.assert_allclose(layers.weights @ layers.spectra, expected, rtol=1e-4)


def test_two_colours_of_light_work(generator):
    layers = light_layers(panorama(generator.random((H, W, 2)), np.stack([planck(2856.0), daylight(6500.0)])))
    assert layers.residual < 1e-6
    assert np.abs(layers.spectra).max() < 100 * layers.spectra.mean()  # no corner at infinity


def test_several_bases_and_more_kinds_of_light_than_three(generator):
    tubes = np.stack([illuminant(name) / 100 for name in ("FL2", "FL11", "A", "D65")])
    glass = tubes * np.linspace(0.2, 1.0, 61)
    index = generator.random((H, W)) < 0.1
    probe = panorama(generator.dirichlet(np.ones(4), size=(H, W)), np.stack([tubes, glass]), index)
    layers = light_layers(probe)
    assert layers.weights.min() >= 0
    lost = ((layers.weights @ layers.spectra - spectra_of(probe)) ** 2).sum(-1)
    solid = np.sin(np.pi * (np.arange(H) + 0.5) / H)[:, None]
    exact = (lost * solid).sum() / ((spectra_of(probe) ** 2).sum(-1) * solid).sum()
    assert 1e-4 < layers.residual < 0.2
    np.testing.assert_allclose(layers.residual, exact, rtol=0.02)
    colour = delta_e_2000(
        spectra_to_xyz(layers.weights @ layers.spectra), spectra_to_xyz(spectra_of(probe)), white_xyz() * 60.0
    )
    assert colour.mean() < 2.0


def test_noise_in_the_dark_does_not_widen_the_cone(generator):
    probe = pca_panorama(generator)
    noisy = probe.weights.copy()
    dark = generator.random((H, W)) < 0.2
    noisy[dark] = 1e-6 * generator.normal(size=(dark.sum(), 3)) * np.abs(noisy).mean()
    clean, rough = (
        light_layers(panorama(np.where(dark[..., None], 0, probe.weights), probe.bases)),
        light_layers(panorama(noisy, probe.bases)),
    )
    np.testing.assert_allclose(rough.spectra, clean.spectra, rtol=0.05, atol=0.05 * clean.spectra.max())
    assert rough.residual < 1e-6


def test_black_texels_stay_black(generator):
    probe = pca_panorama(generator)
    weights = probe.weights.copy()
    weights[:5] = 0
    assert (light_layers(panorama(weights, probe.bases)).weights[:5] == 0).all()


def test_negative_spectra_are_clipped_and_counted(generator):
    probe = pca_panorama(generator)
    weights = np.abs(probe.weights).mean() * np.ones((H, W, 1))
    weights[:, :12] = -0.5 * weights[:, :12]
    layers = light_layers(panorama(weights, planck(2856.0)[None]))
    assert layers.weights.min() >= 0
    np.testing.assert_allclose(layers.residual, 0.25 * 0.25 / (0.75 + 0.25 * 0.25), rtol=1e-3)


@pytest.mark.parametrize("level", [0.0, -1.0])
def test_no_light_is_refused(level):
    with pytest.raises(RenderError, match="Build the probe again"):
        light_layers(panorama(np.full((H, W, 1), level), planck(2856.0)[None]))


def test_dim_light_keeps_its_colour_beside_bright_windows(generator):
    """More kinds of light than three layers hold: what is a thousand times darker must not take the windows' colours."""
    window = daylight(6500.0)
    red = planck(2856.0) * (0.05 + 0.9 / (1 + np.exp((600 - WAVELENGTHS_NM) / 8)))
    bases = np.stack(
        [window, window * np.exp(-(((WAVELENGTHS_NM - 530) / 30) ** 2)), illuminant("LED-B3"), red]
    )
    weights = generator.random((H, W, 4)) * np.array([1000.0, 300.0, 300.0, 0.0])
    weights[H // 2 :] = generator.random((H - H // 2, W, 4)) * np.array([0.2, 0.0, 0.0, 1.0])
    probe = panorama(weights, bases)
    layers = light_layers(probe)
    true, held = spectra_to_xyz(spectra_of(probe)), spectra_to_xyz(layers.weights @ layers.spectra)
    level = true[..., 1:2]
    assert delta_e_2000(true / level, held / level, white_xyz("D65")).max() < 0.1


def test_colour_error_is_none_for_three_kinds_of_light_and_large_for_four():
    spectra = np.stack(
        [
            planck(2700.0),
            daylight(6500),
            daylight(6500) * glass_transmittance("red"),
            daylight(6500) * glass_transmittance("green"),
        ]
    )
    for kinds, least, most in ((3, 0.0, 0.3), (4, 0.5, 30.0)):
        quarters = np.repeat(np.arange(4) % kinds, W // 4)
        weights = np.zeros((H, W, 4), np.float32)
        weights[:, np.arange(W), quarters] = 1.0
        probe = panorama(weights, spectra)
        assert least <= colour_error(probe, light_layers(probe)) <= most
