"""Ratio estimation on synthetic noise whose truth is known."""

import numpy as np
import pytest
from numpy.typing import NDArray

from spectral_probe.render.ratio import transport

type Array = NDArray[np.float32]

SAMPLES, FEW = 128, 8
SIZE = (96, 128)


def noise(samples: int, seed: int, size: tuple[int, int] = SIZE) -> Array:
    """Mean of exponential samples of mean 1, (H, W, 1): as skewed as path tracing's."""
    rng = np.random.default_rng(seed)
    return rng.gamma(samples, 1.0 / samples, size=(*size, 1)).astype(np.float32)


class Render:
    """Two kinds of paths, each with its own reflectance at the reference's and the pass's wavelength."""

    def __init__(self, colours: Array, indirect: float = 0.3) -> None:
        self.colours, self.indirect = colours, indirect  # (2 wavelengths, H, W, 3)
        direct, bounced = noise(FEW, 1), noise(FEW, 2)
        rest = noise(SAMPLES - FEW, 3), noise(SAMPLES - FEW, 4)
        self.few = (direct, bounced)
        share = FEW / SAMPLES
        self.all = tuple(share * a + (1 - share) * b for a, b in zip(self.few, rest, strict=True))

    def image(self, wavelength: int, parts: tuple[Array, ...] | None = None) -> Array:
        """The noisy image of these parts; without parts, the truth."""
        direct, bounced = parts if parts else (np.float32(1), np.float32(1))
        surface = self.colours[wavelength]
        return (surface * direct + self.indirect * surface * surface.mean((0, 1)) * bounced).astype(
            np.float32
        )

    def estimate(self, guide: Array | None = None, low_guide: Array | None = None) -> Array:
        """The transport of wavelength 1 from its few samples."""
        return transport(
            self.image(1, self.few), self.image(0, self.few), self.image(0, self.all), guide, low_guide
        )

    def guide(self, wavelength: int, index: Array | float = 0.0) -> Array:
        """Albedo, normal, index."""
        features = np.zeros((*SIZE, 7), np.float32)
        features[..., :3] = self.colours[wavelength].mean(-1, keepdims=True)
        features[..., 6] = index
        return features


def halves(left: float, right: float) -> Array:
    image = np.full((*SIZE, 3), left, np.float32)
    image[:, SIZE[1] // 2 :] = right
    return image


def error(estimate: Array, truth: Array) -> float:
    return float(np.sqrt((((estimate - truth) / truth) ** 2).mean()))


def test_noise_is_that_of_a_full_pass() -> None:
    render = Render(np.stack([halves(0.5, 0.5), halves(0.3, 0.3)]))
    truth = render.image(1)
    full_pass = error(render.image(1, render.all), truth)
    assert error(render.estimate(), truth) < 1.15 * full_pass
    assert error(render.image(1, render.few), truth) > 3 * full_pass  # the few samples alone are no match


def test_energy_of_each_surface_is_kept() -> None:
    render = Render(np.stack([halves(0.4, 0.6), halves(0.7, 0.05)]))
    index = halves(1, 2)[..., 0]
    estimate = render.estimate(render.guide(0, index), render.guide(1, index))
    full_pass = render.image(1, render.all)
    middle = SIZE[1] // 2
    for side in (slice(0, middle), slice(middle, None)):
        assert estimate[:, side].mean() == pytest.approx(full_pass[:, side].mean(), rel=0.005)


def test_energy_of_the_image_is_kept_without_a_guide() -> None:
    render = Render(np.stack([halves(0.4, 0.6), halves(0.7, 0.05)]))
    assert render.estimate().mean() == pytest.approx(render.image(1, render.all).mean(), rel=0.005)


def test_an_edge_in_the_ratio_stays_sharp() -> None:
    """Two colours that look alike at the reference's wavelength; the pass's own albedo tells them apart."""
    render = Render(np.stack([halves(0.5, 0.5), halves(0.8, 0.05)]))
    estimate = render.estimate(render.guide(0), render.guide(1))
    truth = render.image(1)
    middle = SIZE[1] // 2
    for column in (middle - 1, middle):
        assert estimate[:, column].mean() == pytest.approx(truth[:, column].mean(), rel=0.03)


def test_without_any_guide_an_edge_in_the_ratio_is_found_from_the_pass() -> None:
    render = Render(np.stack([halves(0.5, 0.5), halves(0.8, 0.05)]))
    estimate, truth = render.estimate(), render.image(1)
    middle = SIZE[1] // 2
    assert estimate[:, middle + 6].mean() == pytest.approx(truth[:, middle + 6].mean(), rel=0.25)
    assert estimate[:, middle - 6].mean() == pytest.approx(truth[:, middle - 6].mean(), rel=0.05)


def test_a_firefly_of_the_few_samples_does_not_spread() -> None:
    render = Render(np.stack([halves(0.5, 0.5), halves(0.3, 0.3)]))
    few, reference, full = (
        render.image(1, render.few),
        render.image(0, render.few),
        render.image(0, render.all),
    )
    undisturbed = transport(few, reference, full)
    few[48, 64] *= 1000.0  # a path that only the pass found, ten times its neighbourhood's light
    disturbed = transport(few, reference, full)
    change = np.abs(disturbed - undisturbed) / undisturbed
    far = np.ones(SIZE, bool)
    far[40:57, 56:73] = False
    assert change[far].max() < 0.15


def test_dark_stays_dark_and_nothing_is_invalid() -> None:
    colours = np.stack([halves(0.5, 0.0), halves(0.0, 0.0)])
    estimate = Render(colours).estimate()
    assert np.isfinite(estimate).all()
    assert estimate.min() >= 0
    assert estimate.max() < 0.01
    black = np.zeros((*SIZE, 3), np.float32)
    assert not transport(black, black, black).any()


def test_light_that_the_reference_lacks_is_found() -> None:
    """A saturated surface that is black at the reference's wavelength."""
    render = Render(np.stack([halves(0.5, 0.0), halves(0.3, 0.4)]))
    estimate, truth = render.estimate(), render.image(1)
    right = slice(SIZE[1] // 2 + 6, None)
    assert estimate[:, right].mean() == pytest.approx(truth[:, right].mean(), rel=0.1)


def test_what_has_no_noise_is_exact() -> None:
    """A background seen directly is the same at all wavelengths."""
    background = np.random.default_rng(5).uniform(0.1, 4.0, (*SIZE, 3)).astype(np.float32)
    np.testing.assert_allclose(transport(background, background, background), background, rtol=2e-3)
