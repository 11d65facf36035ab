"""Merged brackets against the radiance they were simulated from."""

from pathlib import Path

import numpy as np
import pytest

from spectral_probe.errors import PhotographError
from spectral_probe.model import Exposure, Photograph
from spectral_probe.photo.merge import merge
from spectral_probe.photo.noise import FULL_WELL_ELECTRONS, READ_NOISE

TIMES = (0.001, 0.008, 0.064)


def shoot(radiance, time_s, rng, **kind):
    """A noisy exposure of a radiance (H, W, 3), as the noise model says."""
    level = radiance * time_s
    noisy = rng.poisson(level * FULL_WELL_ELECTRONS) / FULL_WELL_ELECTRONS
    noisy = noisy + rng.normal(0.0, READ_NOISE, level.shape)
    pixels = np.minimum(noisy, 1.0).astype(np.float32)
    return Photograph(Path(f"{time_s}.dng"), pixels, (pixels >= 0.98).any(-1), Exposure(time_s), **kind)


def bracket(radiance, seed=0):
    rng = np.random.default_rng(seed)
    return [shoot(radiance, time_s, rng) for time_s in TIMES], [Exposure(t) for t in TIMES]


@pytest.mark.parametrize("level", [0.05, 1.0, 30.0, 500.0])
def test_radiance_and_variance_are_right(level):
    truth = np.full((200, 200, 3), level)
    merged = merge(*bracket(truth))
    assert merged.valid.all()
    error = merged.radiance - level
    spread = error.std()
    assert abs(error.mean()) < 5 * spread / np.sqrt(truth.size) + 0.002 * level
    assert np.sqrt(merged.variance.mean()) == pytest.approx(spread, rel=0.15)


def test_merging_beats_the_best_single_photograph():
    truth = np.full((200, 200, 3), 8.0)
    photographs, exposures = bracket(truth)
    merged = merge(photographs, exposures)
    best = min((p.pixels / e.relative - 8.0).std() for p, e in zip(photographs, exposures, strict=True))
    assert merged.radiance.std() < best


def test_saturated_everywhere_is_invalid_and_a_lower_bound():
    truth = np.full((4, 4, 3), 2.0)
    truth[1, 2] = 5000.0
    merged = merge(*bracket(truth))
    assert np.argwhere(~merged.valid).tolist() == [[1, 2]]
    assert merged.radiance[1, 2].min() == pytest.approx(1000.0, rel=0.01)  # 1 / the shortest time
    assert np.isinf(merged.variance[1, 2]).all()


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 2, 0)])
def test_order_hardly_matters_and_an_iterator_will_do(order):
    truth = np.random.default_rng(5).uniform(0.1, 900.0, (50, 60, 3))
    photographs, exposures = bracket(truth)
    reference = merge(photographs, exposures)
    merged = merge([photographs[i] for i in order], [exposures[i] for i in order])
    np.testing.assert_array_equal(merged.valid, reference.valid)
    difference = np.abs(merged.radiance - reference.radiance) / np.sqrt(reference.variance)
    assert np.median(difference[reference.valid]) < 0.3


def test_iso_and_aperture_count():
    pixels = np.full((2, 2, 3), 0.5, np.float32)
    clear = np.zeros((2, 2), bool)
    merged = merge([Photograph(Path("a"), pixels, clear)], [Exposure(0.01, 400, 2)])
    assert merged.radiance[0, 0, 0] == pytest.approx(0.5 / 0.01)


def test_display_referred_prefers_mid_tones():
    clear = np.zeros((1, 1), bool)

    def flat(value):
        return Photograph(Path("a.jpg"), np.full((1, 1, 3), value, np.float32), clear, display_referred=True)

    # A crushed shadow claims 0.5, a mid-tone 1.0: the mid-tone must all but decide.
    merged = merge([flat(0.0005), flat(0.25)], [Exposure(0.001), Exposure(0.25)])
    assert merged.radiance[0, 0, 0] == pytest.approx(1.0, abs=0.02)


def test_different_sizes_and_no_photographs_are_refused():
    one = Photograph(Path("a"), np.zeros((2, 2, 3), np.float32), np.zeros((2, 2), bool))
    two = Photograph(Path("b"), np.zeros((2, 3, 3), np.float32), np.zeros((2, 3), bool))
    with pytest.raises(PhotographError, match="b and a have different sizes"):
        merge([one, two], [Exposure(1.0), Exposure(1.0)])
    with pytest.raises(PhotographError, match="no photographs"):
        merge([], [])


def test_gym_photographs_agree_with_their_merge(shared_dir):
    from spectral_probe.photo.read import read_photograph

    photographs = [read_photograph(shared_dir / f"captures/gym/view0_{i}.dng") for i in range(5)]
    merged = merge(photographs, [p.exposure for p in photographs])
    assert merged.valid.all()
    for p in photographs:
        seen = ~p.clipped
        ratio = (p.pixels[seen] / p.exposure.relative).sum(0) / merged.radiance[seen].sum(0)
        np.testing.assert_allclose(ratio, 1.0, atol=0.002)
