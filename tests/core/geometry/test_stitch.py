"""Views of known surroundings put together must give those surroundings back, whatever is wrong with one of the views."""

import numpy as np
import pytest

from spectral_probe.geometry.frames import (
    bearing_to_direction,
    panorama_directions,
    panorama_solid_angles,
)
from spectral_probe.geometry.panorama import view_panorama
from spectral_probe.geometry.sphere import blurred, fill_unknown, padded, resized
from spectral_probe.geometry.stitch import Blend, doubts, view_score

WIDTH, HEIGHT = 256, 128
ARRANGEMENTS = {
    "one": [(40, 10, 0)],
    "two opposite": [(0, 0, 0), (180, 0, 0)],
    "three": [(0, 0, 0), (120, 0, 0), (240, 0, 0)],
    "twenty": [(17 * n * n % 360, (13 * n) % 60 - 25, n % 7 - 3) for n in range(20)],
}


def unwrapped(view):
    return view_panorama(view.image, view.camera, view.ball, view.rotation, WIDTH)


def merged(views, composition="blend", gains=None):
    """The views' responses put together one at a time, as the pipeline does it, and where any is valid."""
    doubt = doubts(views, gains=gains)
    blend = Blend(HEIGHT, WIDTH, 3)
    for number, view in enumerate(views):
        gain = np.ones(3) if gains is None else gains[number]
        own = resized(doubt[number], WIDTH)
        for rows in (slice(0, 50), slice(50, HEIGHT)):
            score = view_score(view, own, 0.01, composition, rows)
            blend.add(rows, view.responses[rows] * gain.astype(np.float32), score)
    return blend.mean(), np.any([view.valid for view in views], axis=0)


def relative_error(found, truth):
    return np.abs(found - truth).max(-1) / truth.max(-1)


@pytest.fixture(scope="module")
def arranged(surroundings):
    """The unwrapped views of an arrangement, made once."""
    made = {}

    def get(arrangement):
        if arrangement not in made:
            made[arrangement] = [
                unwrapped(surroundings().view(angles)) for angles in ARRANGEMENTS[arrangement]
            ]
        return made[arrangement]

    return get


@pytest.fixture(scope="module")
def truth(surroundings):
    return resized(surroundings().panorama, WIDTH)


@pytest.mark.parametrize("composition", ["blend", "cut"])
@pytest.mark.parametrize("arrangement", ARRANGEMENTS)
def test_the_surroundings_come_back(arranged, truth, arrangement, composition):
    views = arranged(arrangement)
    found, valid = merged(views, composition)
    error = relative_error(found, truth)
    best = np.max([view.cos_incidence for view in views], axis=0)
    sharp = valid & (best > 0.5)
    assert np.median(error[sharp]) < 0.03
    assert np.percentile(error[sharp], 99) < 0.25  # lamps' edges, over a pixel of the photograph
    solid_angle = np.broadcast_to(panorama_solid_angles(HEIGHT, WIDTH), valid.shape)
    unseen = float(solid_angle[~valid].sum() / (4 * np.pi))
    assert unseen < (0.02 if arrangement == "one" else 1e-9)
    energy = [(image * solid_angle[..., None])[valid].sum() for image in (found, truth)]
    assert energy[0] == pytest.approx(energy[1], rel=0.02)


def test_the_plain_cut_is_sixty_degrees_to_each_side(arranged, view_shares):
    shares = view_shares(arranged("three"), "cut")
    directions = panorama_directions(HEIGHT, WIDTH)
    bearing = np.degrees(np.arctan2(directions[..., 0], directions[..., 1]))
    for (azimuth, _, _), share in zip(ARRANGEMENTS["three"], shares, strict=True):
        phi = np.abs((bearing - (azimuth + 180) + 180) % 360 - 180)  # from the direction to the camera
        assert share[phi < 58].min() > 0.99
        assert share[phi > 62].max() < 0.01


def test_shares_do_not_depend_on_the_order(arranged, view_shares):
    views = arranged("three")
    forward, _ = merged(views)
    backward, _ = merged(views[::-1])
    assert np.allclose(forward, backward, rtol=1e-3, atol=1e-4)
    shares = view_shares(views)
    at_once = sum(share[..., None] * view.responses for share, view in zip(shares, views, strict=True))
    assert np.allclose(forward, at_once, rtol=1e-3, atol=1e-4)


@pytest.mark.parametrize("arrangement", ["two opposite", "three"])
def test_the_photographer_goes(surroundings, truth, arrangement):
    """Someone dark beside one camera, 15 degrees wide, whom the other views do not see."""
    figure = bearing_to_direction(166.0, -8.0)  # the first camera is at bearing 180

    def stand_there(directions, radiance):
        return np.where((directions @ figure > np.cos(np.radians(7.5)))[..., None], 0.05, radiance)

    world = surroundings()
    angles = ARRANGEMENTS[arrangement]
    views = [
        unwrapped(world.view(pose, change=stand_there if number == 0 else None))
        for number, pose in enumerate(angles)
    ]
    found, _ = merged(views)
    inside = panorama_directions(HEIGHT, WIDTH) @ figure > np.cos(np.radians(6.5))
    assert np.median(found[inside] / truth[inside]) == pytest.approx(1.0, abs=0.05)
    assert (found[inside] > 0.15).all()
    alone, _ = merged(views[:1])
    assert np.median(alone[inside]) < 0.1  # nobody else to ask


def test_wrong_levels_are_no_seams_once_matched(surroundings, truth):
    world = surroundings()
    factors = np.array([1.0, 1.3, 0.8])
    views = [
        unwrapped(world.view(pose, change=lambda _, radiance, factor=factor: factor * radiance))
        for pose, factor in zip(ARRANGEMENTS["three"], factors, strict=True)
    ]
    gains = np.repeat(1 / factors[:, None], 3, axis=1)
    assert np.median(relative_error(merged(views, gains=gains)[0], truth)) < 0.03


def test_bright_lamps_neither_ring_nor_smear(surroundings):
    """A lamp of 3000 : 1 in views 0.7 degrees out of place: nothing negative, nothing dark, no light far from it."""
    lamp = bearing_to_direction(120.0, 25.0)  # between the cameras at bearings 180 and 60 (300): blended

    def light(directions, radiance):
        return np.where((directions @ lamp > np.cos(np.radians(2.0)))[..., None], 3000.0, 0 * radiance + 1.0)

    world = surroundings()
    poses = [(0, 0, 0), (120, 0, 0), (240, 0, 0)]
    views = [
        unwrapped(world.view(pose, (0.7 * (number == 1), 0, 0), change=light))
        for number, pose in enumerate(poses)
    ]
    found, _ = merged(views)
    directions = panorama_directions(HEIGHT, WIDTH)
    assert found.min() > 0.999
    away = directions @ lamp < np.cos(np.radians(7.0))
    assert found[away].max() < 1.5
    solid_angle = panorama_solid_angles(HEIGHT, WIDTH)
    energy = float(((found[..., 0] - 1) * solid_angle).sum())
    assert energy == pytest.approx(2999 * 2 * np.pi * (1 - np.cos(np.radians(2.0))), rel=0.1)


def test_things_that_all_views_see_elsewhere_are_not_torn(surroundings, view_shares):
    """Where no two views agree, none is doubted: shares stay those of the sampling, and so stay smooth."""
    views = [
        unwrapped(surroundings(seed=seed).view(pose))
        for seed, pose in zip((3, 11, 12), ARRANGEMENTS["three"], strict=True)
    ]
    steepest = np.abs(np.diff(view_shares(views), axis=2)).max(0)
    calm = np.max([view.facing_rad for view in views], axis=0) < np.radians(140)
    assert np.percentile(steepest[calm[:, 1:]], 95) < 0.3


def test_filling_goes_round_and_over_the_poles():
    """A gap across the panorama's edge and over a pole is filled from both sides."""
    directions = panorama_directions(64, 128)
    values = (2 + directions).astype(np.float32)
    known = np.ones((64, 128), bool)
    known[20:44, :6] = known[20:44, -6:] = False
    known[:5] = False
    filled = fill_unknown(np.where(known[..., None], values, 0), known)
    assert np.array_equal(filled[known], values[known])
    assert np.abs(filled - values)[~known].max() < 0.25
    assert np.abs(filled[30, 0] - filled[30, -1]).max() < 0.1  # no seam where the panorama closes


def test_blur_is_the_same_everywhere():
    """A spot near a pole, on the seam and on the equator is spread to the same peak, and keeps its energy."""
    width = np.radians(6.0)
    peaks = []
    for azimuth, elevation in ((10, 0), (-90, 0), (33, 55), (33, -78)):
        spot = panorama_directions(128, 256) @ bearing_to_direction(azimuth, elevation)
        image = np.exp((spot - 1) / np.radians(4.0) ** 2).astype(np.float32)
        spread = blurred(image, width)
        peaks.append(float(spread.max()))
    assert np.ptp(peaks) < 0.12 * np.mean(peaks)
    assert np.allclose(blurred(np.ones((32, 64, 2)), 0.2), 1, atol=1e-5)


def test_padding_continues_the_sphere():
    image = panorama_directions(16, 32)
    around = padded(image, 2, 3)
    assert around.shape == (20, 38, 3)
    steps = np.linalg.norm(np.diff(around, axis=0), axis=-1)
    assert steps.max() < 0.21  # neighbours stay neighbours over the poles: pi / 16 apart


def test_resizing_up_and_down_keeps_a_smooth_panorama():
    image = panorama_directions(64, 128).astype(np.float32)
    assert np.abs(resized(resized(image, 256), 128) - image).max() < 0.01


def test_black_views_are_no_trouble(surroundings):
    world = surroundings()
    views = [
        unwrapped(world.view(pose, change=lambda _, radiance: 0 * radiance))
        for pose in ARRANGEMENTS["two opposite"]
    ]
    found, valid = merged(views)
    assert valid.all()
    assert np.array_equal(found, np.zeros_like(found))
