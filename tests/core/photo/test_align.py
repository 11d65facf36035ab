"""Brackets with known shifts between their photographs."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from spectral_probe.errors import PhotographError
from spectral_probe.model import Photograph
from spectral_probe.photo.align import align, register

SCENE = 600


def scene(seed=0):
    """Smooth detail over four decades of radiance, on a canvas larger than any photograph of it."""
    noise = np.random.default_rng(seed).normal(size=(SCENE, SCENE, 3)).astype(np.float32)
    detail = sum(cv2.GaussianBlur(noise, (0, 0), s) * s for s in (3, 8, 25))
    return np.exp(1.2 * detail / detail.std())


def photograph(canvas, corner, size, time_s, name="a.png", noise=0.002):
    """What a camera sees whose frame begins at `corner` (x, y) of the canvas."""
    matrix = np.array([[1.0, 0.0, corner[0]], [0.0, 1.0, corner[1]]])
    flags = cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP
    seen = cv2.warpAffine(canvas, matrix, size, flags=flags) * time_s
    seen = seen + np.random.default_rng(len(name)).normal(0.0, noise, seen.shape)
    pixels = np.clip(seen, 0.0, 1.0).astype(np.float32)
    return Photograph(Path(name), pixels, pixels.max(-1) >= 0.99)


def test_a_still_camera_leaves_the_arrays_alone():
    canvas = scene()
    bracket = [photograph(canvas, (100, 100), (300, 280), t) for t in (0.02, 0.1, 0.5)]
    circles = [(150 + d, 140, 120) for d in (0.0, 0.2, -0.2)]  # as well as outlines are found
    shifts = register(bracket, circles)
    assert all(a is b for a, b in zip(align(bracket, shifts), bracket, strict=True))


@pytest.mark.parametrize("shift", [(7.0, -4.0), (1.3, 0.6), (-12.4, 3.7)])
def test_shifts_are_found_to_a_tenth_of_a_pixel(shift):
    canvas = scene(1)
    first = photograph(canvas, (100, 100), (300, 280), 0.1)
    second = photograph(canvas, (100 - shift[0], 100 - shift[1]), (300, 280), 0.4, "bb.png")
    # The outlines are out by 2 px, as those of a blurred ball can be.
    found = register([first, second], [(150, 140, 120), (152 + shift[0], 139 + shift[1], 120)])
    np.testing.assert_allclose(found[1], shift, atol=0.1)


def test_clipped_areas_do_not_pull_the_shift():
    """A third of the brighter photograph is clipped; sub-pixel shifts are found to 0.06 px RMS all the same."""
    errors = []
    for seed, shift in enumerate([(0.4, -0.3), (-2.5, 1.2), (3.7, 0.6), (0.0, 0.8)]):
        canvas = scene(10 + seed)
        first = photograph(canvas, (100, 100), (300, 280), 0.06)
        second = photograph(canvas, (100 - shift[0], 100 - shift[1]), (300, 280), 0.24, "bb.png")
        assert 0.15 < second.clipped.mean() < 0.5
        found = register([first, second], [(150, 140, 120), (151 + shift[0], 140 + shift[1], 120)])
        errors.append(found[1] - shift)
    assert np.sqrt(np.mean(np.square(errors))) < 0.06


def test_crops_of_different_sizes_come_to_the_first_ones_frame():
    canvas = scene(2)
    first = photograph(canvas, (100, 100), (300, 280), 0.1)
    second = photograph(canvas, (109, 94), (310, 290), 0.2, "bb.png")
    aligned = align([first, second], register([first, second], [(150, 140, 120), (141, 146, 120)]))
    assert aligned[0] is first
    assert aligned[1].pixels.shape == first.pixels.shape
    both = ~(first.clipped | aligned[1].clipped)
    difference = aligned[1].pixels[both] / 2.0 - first.pixels[both]
    assert np.abs(difference).mean() < 0.004  # the noise of both; whole pixels are copied, not interpolated
    # The second crop begins 9 px further right: what lies left of it was never photographed.
    assert aligned[1].clipped[:, :9].all()
    assert not aligned[1].clipped[:, 9:].all(axis=0).any()


def test_clipped_pixels_spread_when_interpolated():
    canvas = scene(3)
    canvas[250, 250] = 1e4
    first = photograph(canvas, (100, 100), (300, 280), 0.1)
    second = photograph(canvas, (100.5, 100.5), (300, 280), 0.1, "bb.png")
    aligned = align([first, second], [np.zeros(2), np.array([-0.5, -0.5])])
    assert np.count_nonzero(aligned[1].clipped[140:160, 140:160]) >= 16
    unclipped = ~(aligned[1].clipped | first.clipped)
    assert np.abs(aligned[1].pixels - first.pixels)[unclipped].max() < 0.15


def test_counts_must_fit():
    one = photograph(scene(), (100, 100), (60, 60), 0.1)
    with pytest.raises(PhotographError, match="0 shifts for 1 photographs"):
        align([one], [])


def test_gym_brackets_are_untouched(shared_dir):
    from spectral_probe.photo.read import read_photograph

    for view in range(3):
        bracket = [read_photograph(shared_dir / f"captures/gym/view{view}_{i}.dng") for i in range(5)]
        shifts = register(bracket, [(400, 400, 358.2)] * 5)
        assert all(a is b for a, b in zip(align(bracket, shifts), bracket, strict=True))


def test_office_crops_agree_with_their_full_frames(shared_dir):
    from spectral_probe.photo.read import read_photograph

    folder = shared_dir / "photos/bracket_a6000_office"
    names = ["cp_t160.jpg", "cp_t320.jpg", "cp_t1250.jpg", "cp_t4000.jpg"]
    bracket = [read_photograph(folder / name) for name in names]
    # Hand circles (balls.json), wrong by up to 6 px; the pictures of the ball tell better.
    circles = [(726.6, 727.2, 720), (726.6, 729.4, 719), (721.7, 735.4, 722), (727.3, 737.2, 723)]
    shifts = register(bracket, circles)
    again = register([bracket[0], *bracket[:0:-1]], [circles[0], *circles[:0:-1]])
    np.testing.assert_allclose(shifts[1:], again[:0:-1], atol=0.2)
    moved = align(bracket, shifts)
    here, there = (cv2.cvtColor(p.pixels[300:1100, 300:1100], cv2.COLOR_RGB2GRAY) for p in moved[:2])
    seen = ~(moved[0].clipped | moved[1].clipped)[300:1100, 300:1100]
    assert np.corrcoef(here[seen], there[seen])[0, 1] > 0.94  # tone curves differ, and people moved
