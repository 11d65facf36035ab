import cv2
import numpy as np
import pytest

from spectral_probe.geometry.ball import reflect
from spectral_probe.geometry.camera import pixel_rays
from spectral_probe.geometry.frames import (
    bearing_to_direction,
    camera_to_world,
    panorama_directions,
    panorama_solid_angles,
)
from spectral_probe.geometry.panorama import _PlaceFinder, natural_width, view_panorama
from spectral_probe.geometry.sampling import sampling
from spectral_probe.geometry.sphere import fill_unknown
from spectral_probe.model import BallFit, Camera, RadianceImage

CAMERA = Camera((2000.0, 2000.0), (205.0, 196.0), (400, 400))
BALL = BallFit(
    np.array([0.004, -0.002, 0.6]), 0.05, float(np.arcsin(0.05 / np.linalg.norm([0.004, -0.002, 0.6]))), 0.0
)


def smooth_world(directions):
    """Light that varies slowly and differently in every channel."""
    x, y, z = np.moveaxis(directions, -1, 0)
    return np.stack([2 + x + 0.3 * y * z, 2 + y - 0.2 * x, 2 + z + 0.4 * x * y], axis=-1)


def photograph_of(world, rotation, offset_px=(0.0, 0.0)):
    """A mirrored-ball image, one ray a pixel, at its centre or a little off it."""
    columns, rows = np.meshgrid(np.arange(400) + 0.5, np.arange(400) + 0.5)
    pixels = np.stack([columns, rows], axis=-1) + offset_px
    mirrored = reflect(BALL, pixel_rays(CAMERA, pixels))
    radiance = np.where(mirrored.hit[..., None], world(mirrored.directions @ rotation.T), 0.0).astype(
        np.float32
    )
    return RadianceImage(radiance, np.full_like(radiance, 1e-4), np.ones((400, 400), bool))


@pytest.mark.parametrize(("azimuth", "elevation"), [(0, 0), (120, 25), (250, -15)])
def test_a_view_gives_back_the_world(azimuth, elevation):
    rotation = camera_to_world(azimuth, elevation)
    view = view_panorama(photograph_of(smooth_world, rotation), CAMERA, BALL, rotation, 256)
    truth = smooth_world(panorama_directions(128, 256))
    good = view.seen & (view.cos_incidence > 0.25)
    assert good.mean() > 0.8
    assert (
        np.abs(view.responses - truth)[good].max() < 0.05
    )  # a pixel spans up to 2 degrees at that incidence
    assert np.abs(view.responses - truth)[view.cos_incidence > 0.6].max() < 0.01


def test_a_lamp_is_where_it_is():
    lamp = bearing_to_direction(75.0, 30.0)

    def world(directions):
        glow = np.exp((directions @ lamp - 1) / (1 - np.cos(np.radians(3))))
        return np.repeat(glow[..., None], 3, axis=-1)

    rotation = camera_to_world(20)
    view = view_panorama(photograph_of(world, rotation), CAMERA, BALL, rotation, 512)
    directions = panorama_directions(256, 512)
    weight = (
        view.responses[..., 0] * np.hypot(directions[..., 0], directions[..., 1]) * (directions @ lamp > 0.97)
    )
    found = (weight[..., None] * directions).sum((0, 1))
    assert np.degrees(np.arccos(found @ lamp / np.linalg.norm(found))) < 0.1


def lamps_and_room(directions):
    """A dim room with five lamps of 3 degrees, 1000 times as bright."""
    lamps = bearing_to_direction(
        np.array([180.0, 120.0, 60.0, 25.0, -40.0]), np.array([10.0, 40.0, -20.0, 30.0, 5.0])
    )
    lit = (directions @ lamps.T > np.cos(np.radians(3.0))).any(axis=-1)
    return np.repeat(np.where(lit, 1000.0, 1.0 + 0.5 * directions[..., 2])[..., None], 3, axis=-1)


@pytest.mark.parametrize("width", [128, 256, 512, 1024, 2048])
def test_energy_is_kept_at_any_width(width):
    """The integral of radiance over what the view sees, lamps and all, is that of the world within 0.5 %."""
    rotation = camera_to_world(0)
    fine = [
        photograph_of(lamps_and_room, rotation, offset).radiance
        for offset in np.stack(
            np.meshgrid([-0.375, -0.125, 0.125, 0.375], [-0.375, -0.125, 0.125, 0.375]), -1
        ).reshape(-1, 2)
    ]
    image = RadianceImage(np.mean(fine, axis=0), np.full_like(fine[0], 1e-4), np.ones((400, 400), bool))
    view = view_panorama(image, CAMERA, BALL, rotation, width)
    directions = panorama_directions(1024, 2048)
    shown = view.facing_rad < np.radians(165)
    seen = cv2.resize(shown.astype(np.uint8), (2048, 1024), interpolation=cv2.INTER_NEAREST) > 0
    truth = (lamps_and_room(directions)[..., 0] * seen * panorama_solid_angles(1024, 2048)).sum()
    found = (view.responses[..., 0] * shown * panorama_solid_angles(width // 2, width)).sum()
    assert found == pytest.approx(truth, rel=0.005)


def test_averaging_down_lowers_the_noise_as_it_should():
    rng = np.random.default_rng(5)
    noise = rng.normal(0.0, 0.01, size=(400, 400, 3)).astype(np.float32)
    image = RadianceImage(1.0 + noise, np.full((400, 400, 3), 1e-4, np.float32), np.ones((400, 400), bool))
    view = view_panorama(image, CAMERA, BALL, camera_to_world(0), 128)
    level = (slice(16, 48), slice(None))  # towards the poles texels share pixels
    inner = view.facing_rad[level] < np.radians(110)
    assert 0.5 < view.responses[level][inner].var() / view.variance[level][inner].mean() < 1.1


def test_places_between_texels_are_exact_enough():
    """Large panoramas interpolate places away from the rim: within a hundredth of a pixel of the exact ones."""
    finder = _PlaceFinder(CAMERA, BALL, camera_to_world(40, 20, 5), 4096)
    for start in (0, 512, 1024, 2044):
        rows = slice(start, start + 4)
        columns, lines = np.arange(4096) + 0.5, np.arange(start, start + 4)[:, None] + 0.5
        for found, exact in zip(finder.places(rows), finder._exact(columns, lines), strict=True):
            assert np.abs(found - exact).max() < 0.01


def test_natural_width_follows_the_ball():
    assert (
        natural_width([sampling(CAMERA, BALL, np.eye(3))]) == 576
    )  # pi times the ball's 166 pixels, and perspective


def test_clipped_pixels_make_invalid_texels_and_no_others():
    rotation = camera_to_world(0)
    image = photograph_of(smooth_world, rotation)
    image.valid[180:220, 240:260] = False
    image.variance[180:220, 240:260] = np.inf
    view = view_panorama(image, CAMERA, BALL, rotation, 256)
    lost = view.seen & ~view.valid
    assert 0.0005 < lost.mean() < 0.02
    assert np.isfinite(view.variance).all()


def test_the_blind_cone_is_not_seen():
    rotation = camera_to_world(0)
    view = view_panorama(photograph_of(smooth_world, rotation), CAMERA, BALL, rotation, 512)
    behind = panorama_directions(256, 512) @ np.array([0.0, 1.0, 0.0])
    assert not view.seen[behind > np.cos(BALL.cone_angle_rad)].any()
    assert view.seen[behind < np.cos(BALL.cone_angle_rad + np.radians(5))].all()


def test_views_fill_in_for_each_other(view_shares):
    views = []
    for azimuth in (0, 120, 240):
        rotation = camera_to_world(azimuth)
        views.append(view_panorama(photograph_of(smooth_world, rotation), CAMERA, BALL, rotation, 128))
    shares = view_shares(views)
    assert np.allclose(shares.sum(0), 1, atol=1e-5)
    directions = panorama_directions(64, 128)
    for view, share in zip(views, shares, strict=True):
        towards_itself = view.facing_rad < np.radians(8)
        assert share[towards_itself].max() < 0.01  # a camera's own reflection comes from the others
        assert share[view.cos_incidence < 0.2].max() < 0.05
    merged = sum(share[..., None] * view.responses for view, share in zip(views, shares, strict=True))
    assert np.abs(merged - smooth_world(directions)).max() < 0.02


def test_what_one_view_alone_shows_is_left_out(view_shares):
    """A dark figure beside the camera, wider than the camera's own reflection, is in one view of three."""
    figure = bearing_to_direction(160.0, -10.0)  # seen by the view from there, whose camera is at bearing 180
    views = []
    for azimuth in (0, 120, 240):
        rotation = camera_to_world(azimuth)

        def world(directions, azimuth=azimuth):
            near = (
                directions @ figure > np.cos(np.radians(12))
                if azimuth == 0
                else np.zeros(directions.shape[:-1], bool)
            )
            return np.where(near[..., None], 0.2, smooth_world(directions))

        views.append(view_panorama(photograph_of(world, rotation), CAMERA, BALL, rotation, 128))
    merged = sum(
        share[..., None] * view.responses for view, share in zip(views, view_shares(views), strict=True)
    )
    directions = panorama_directions(64, 128)
    inside = directions @ figure > np.cos(np.radians(9))
    assert np.abs(merged - smooth_world(directions))[inside].max() < 0.1
    pair = views[:2]  # of two that disagree, the one is believed that does not look at its own camera there
    kept = sum(share[..., None] * view.responses for view, share in zip(pair, view_shares(pair), strict=True))
    assert np.abs(kept - smooth_world(directions))[inside].max() < 0.1


def test_a_lamp_that_only_one_view_has_unclipped_is_kept(view_shares):
    """Two views clip the lamp and hold less than its radiance; agreeing in that, they must not outvote the third."""
    lamp = bearing_to_direction(30.0, 50.0)
    views = []
    for azimuth, level in ((0, 3.0), (120, 1.0), (240, 1.0)):
        rotation = camera_to_world(azimuth)

        def world(directions, level=level):
            near = directions @ lamp > np.cos(np.radians(9))
            return np.where(near[..., None], 10.0 * level, smooth_world(directions))

        image = photograph_of(world, rotation)
        image.valid[(image.radiance[..., 0] > 9) & (level == 1.0)] = False
        views.append(view_panorama(image, CAMERA, BALL, rotation, 128))
    merged = sum(
        share[..., None] * view.responses for view, share in zip(views, view_shares(views), strict=True)
    )
    inside = (panorama_directions(64, 128) @ lamp > np.cos(np.radians(6))) & views[0].valid
    assert inside.any()
    assert (
        np.abs(merged[inside] - 30.0).max() < 1.5
    )  # a texel beside the lamp's edge holds a little of what is around


def test_filling_keeps_what_is_known():
    rng = np.random.default_rng(7)
    values = rng.uniform(1, 2, size=(32, 64, 2)).astype(np.float32)
    known = rng.random((32, 64)) > 0.2
    known[10:20, 20:40] = False
    filled = fill_unknown(np.where(known[..., None], values, 0), known)
    assert np.array_equal(filled[known], values[known])
    assert filled[~known].min() > 0.9
    assert filled[~known].max() < 2.1
