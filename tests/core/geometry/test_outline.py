"""Outlines of simulated mirrored balls against their geometry, and of real ones against hand-drawn circles."""

import json
import re
from pathlib import Path

import cv2
import numpy as np
import pytest

from spectral_probe.errors import OutlineError
from spectral_probe.geometry.ball import fit_ball
from spectral_probe.geometry.ellipse import Ellipse
from spectral_probe.geometry.outline import (
    check_in_frame,
    find_ball,
    outline_from_circle,
)
from spectral_probe.model import Camera, Photograph
from spectral_probe.photo.read import read_photograph, srgb_to_linear


def world(directions, seed=0, turned=True):
    """Radiance (..., 3) of a room far away: six walls of different colours with soft shading, panels and a window."""
    rng = np.random.default_rng(seed)
    if turned:  # few cameras look straight at a wall
        directions = directions @ cv2.Rodrigues(np.array([0.25, 0.6 + seed, 0.1]))[0]
    colours = rng.uniform(0.1, 0.6, (6, 3))
    spots = rng.uniform(-1.0, 1.0, (6, 4, 2))
    dominant = np.abs(directions).argmax(-1)
    along = np.take_along_axis(directions, dominant[..., None], -1)[..., 0]
    face = dominant * 2 + (along > 0)
    on_wall = directions / np.abs(along)[..., None]
    u = np.where(dominant == 0, on_wall[..., 1], on_wall[..., 0])
    v = np.where(dominant == 2, on_wall[..., 1], on_wall[..., 2])
    total = colours[face] * (1.0 + 0.3 * u + 0.2 * v * u)[..., None]
    for panel in range(4):
        at = spots[face, panel]
        inside = (np.abs(u - at[..., 0]) < 0.2) & (np.abs(v - at[..., 1]) < 0.15) & (face != 5)
        total = np.where(inside[..., None], colours[(face + panel) % 6] * (4.0 if panel == 0 else 0.7), total)
    return total


def render(size, focal_px, centre_m, radius_m=0.05, seed=0, supersample=4, turned=True):
    """A pinhole picture of a mirrored ball in a distant world (H, W, 3), exact but for its pixels' sampling."""
    width, height = size
    total = np.zeros((height, width, 3))
    centre = np.asarray(centre_m, float)
    for sub in np.ndindex(supersample, supersample):
        row, column = np.indices((height, width)) + ((np.array(sub) + 0.5) / supersample)[:, None, None]
        rays = np.stack(
            [(column - width / 2) / focal_px, (row - height / 2) / focal_px, np.ones_like(row)], -1
        )
        rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
        along = rays @ centre
        inside = along**2 - centre @ centre + radius_m**2
        hit = inside > 0
        point = (along - np.sqrt(np.maximum(inside, 0)))[..., None] * rays
        normal = (point - centre) / radius_m
        reflected = rays - 2.0 * (rays * normal).sum(-1, keepdims=True) * normal
        total += world(np.where(hit[..., None], reflected, rays), seed, turned)
    return total / supersample**2


def shoot(radiance, exposure=1.0, noise=0.002, seed=1, **kind):
    noisy = radiance * exposure + np.random.default_rng(seed).normal(0.0, noise, radiance.shape)
    pixels = np.minimum(noisy, 1.0).astype(np.float32)
    return Photograph(Path("ball.dng"), pixels, pixels.max(-1) >= 0.98, **kind)


def true_points(focal_px, size, centre_m, radius_m=0.05, count=360):
    """Points of the exact outline: the cone round the centre's direction, in pixels."""
    centre = np.asarray(centre_m, float)
    distance = np.linalg.norm(centre)
    axis = centre / distance
    angle = np.arcsin(radius_m / distance)
    side = np.cross(axis, (0.0, 1.0, 0.0))
    side /= np.linalg.norm(side)
    turn = np.linspace(0, 2 * np.pi, count, endpoint=False)[:, None]
    rays = np.cos(angle) * axis + np.sin(angle) * (np.cos(turn) * side + np.sin(turn) * np.cross(axis, side))
    return np.array(size) / 2 + focal_px * rays[:, :2] / rays[:, 2:]


def distances(outline, points):
    """Distance of points from the outline's ellipse along its radii."""
    offset = points - np.array(outline.centre_px)
    ellipse = Ellipse(*outline.centre_px, *outline.semi_axes_px, outline.angle_rad)
    return np.hypot(*offset.T) - ellipse.radius_at(np.arctan2(offset[:, 1], offset[:, 0]))


def detected(photograph):
    """The outline of the ball in one photograph."""
    return find_ball([photograph]).outlines[0]


@pytest.mark.parametrize("seed", [0, 2, 5])
def test_simulated_ball_to_half_a_pixel(seed):
    size, focal, centre = (420, 400), 1500.0, (0.013, -0.008, 0.6)
    photograph = shoot(render(size, focal, centre, seed=seed), 0.5)
    outline = detected(photograph)
    error = distances(outline, true_points(focal, size, centre))
    # A step in place of the cusp is out by 0.7 px and more; walls' edges close to the rim leave some of it.
    assert np.abs(error).max() < 0.6


def test_points_agree_with_the_ellipse():
    size, focal, centre = (420, 400), 1500.0, (0.0, 0.0, 0.6)
    outline = detected(shoot(render(size, focal, centre), 0.5))
    # An unweighted fit to the points must give the outline: they are drawn in by their weight.
    offset = outline.points_px - np.array(outline.centre_px)
    angle = np.arctan2(offset[:, 1], offset[:, 0])
    residual = distances(outline, outline.points_px)
    design = np.stack([np.ones_like(angle), np.cos(angle), np.sin(angle)], -1)
    assert np.abs(np.linalg.lstsq(design, residual, rcond=None)[0]).max() < 0.03


def test_wide_angle_outline_is_an_ellipse():
    # 17 degrees off the axis the outline is 4 % longer than wide.
    size, focal, centre = (700, 500), 700.0, (0.09, 0.02, 0.3)
    outline = detected(shoot(render(size, focal, centre, supersample=3), 0.5))
    error = distances(outline, true_points(focal, size, centre))
    assert outline.semi_axes_px[0] / outline.semi_axes_px[1] > 1.02
    assert np.abs(error).max() < 2.0


@pytest.mark.parametrize("seed", [0, 1])
def test_the_ring_that_the_wall_behind_makes_is_not_the_outline(seed):
    # A camera square to a wall: its four edges are reflected as a strong circle of 0.93 radii.
    size, focal, centre = (420, 400), 1500.0, (0.013, -0.008, 0.6)
    outline = detected(shoot(render(size, focal, centre, seed=seed, turned=False), 0.5))
    assert np.abs(distances(outline, true_points(focal, size, centre))).max() < 0.5


def test_stand_and_reflections_do_not_matter():
    size, focal, centre = (420, 440), 1500.0, (0.0, -0.005, 0.6)
    radiance = render(size, focal, centre, seed=3)
    truth = true_points(focal, size, centre)
    bottom = int(truth[:, 1].max())
    radiance[bottom - 14 :, 150:270] = 0.08  # a block hides the lowest part of the rim
    cv2.circle(
        radiance, (210, 200), 60, (0.05, 0.05, 0.06), -1
    )  # a round thing reflected, concentric or nearly
    outline = detected(shoot(radiance, 0.5))
    visible = truth[:, 1] < bottom - 14
    assert np.abs(distances(outline, truth[visible])).max() < 1.0


def test_a_bracket_helps_out_where_one_photograph_shows_nothing():
    size, focal, centre = (420, 400), 1500.0, (0.004, 0.006, 0.6)
    radiance = render(size, focal, centre, seed=2)
    bracket = [shoot(radiance, exposure, seed=9) for exposure in (40.0, 0.4, 0.01)]  # white, right, black
    outlines = find_ball(bracket).outlines
    assert len(outlines) == 3
    for outline in outlines:
        # Alone, the first and the last show no ball at all; the second reaches 0.5 px.
        assert np.abs(distances(outline, true_points(focal, size, centre))).max() < 1.2


def test_display_referred_jpeg(tmp_path):
    size, focal, centre = (420, 400), 1500.0, (0.0, 0.0, 0.6)
    radiance = np.clip(render(size, focal, centre, seed=5) * 0.6, 0, 1)
    table = srgb_to_linear(np.arange(256) / 255.0)
    codes = np.searchsorted(table, radiance).clip(0, 255).astype(np.uint8)
    cv2.imwrite(str(tmp_path / "ball.jpg"), codes[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 92])
    outline = detected(read_photograph(tmp_path / "ball.jpg"))
    error = distances(outline, true_points(focal, size, centre))
    # A step is fitted to developed pictures; a clean simulated mirror has a cusp, 0.7 px further out.
    assert np.abs(error).max() < 1.5


@pytest.mark.parametrize(
    ("edge", "cut"),
    [
        ("left", np.s_[:, 130:]),
        ("right", np.s_[:, :290]),
        ("top", np.s_[120:]),
        ("bottom", np.s_[:280]),
    ],
)
def test_a_ball_cut_by_the_frame_is_refused(edge, cut):
    radiance = render((420, 400), 1500.0, (0.0, 0.0, 0.6), seed=1)  # the rim reaches from 84 to 336 in x
    with pytest.raises(
        OutlineError, match=f"^The ball touches the {edge} edge of the frame. Photograph it whole"
    ):
        find_ball([shoot(np.ascontiguousarray(radiance[cut]), 0.5)])


def test_no_ball_is_said_in_one_line():
    rows, columns = np.indices((300, 400))
    rays = np.stack([(columns - 200) / 300, (rows - 150) / 300, np.ones((300, 400))], -1)
    photograph = shoot(world(rays / np.linalg.norm(rays, axis=-1, keepdims=True)), 0.5)
    with pytest.raises(OutlineError, match=r"No mirrored ball was found in ball\.dng") as error:
        find_ball([photograph])
    assert "\n" not in str(error.value)
    with pytest.raises(OutlineError):
        find_ball([])


@pytest.fixture(scope="module")
def one_ball():
    return render((420, 400), 1500.0, (0.013, -0.008, 0.6), seed=0, supersample=3)


def test_half_the_rim_hidden(one_ball):
    size, focal, centre = (420, 400), 1500.0, np.array((0.013, -0.008, 0.6))
    hidden = one_ball.copy()
    hidden[int(true_points(focal, size, centre)[:, 1].mean()) :] = (0.08, 0.07, 0.06)
    camera = Camera((focal, focal), (210.0, 200.0), size)
    ball = find_ball([shoot(hidden, 0.5)])
    fit = fit_ball(camera, ball.outlines[0], 0.05)
    distance = np.linalg.norm(centre)
    error = np.array(
        [*(fit.axis_tangents @ centre / distance), fit.cone_angle_rad - np.arcsin(0.05 / distance)]
    )
    assert np.abs(error * focal).max() < 0.6  # pixels; a free circle is out by several
    assert (np.abs(error) < 3.0 * np.sqrt(np.diag(fit.covariance_rad2))).all()


def test_two_balls_are_both_named(one_ball):
    small = render((300, 400), 1500.0, (0.0, 0.0, 0.95), supersample=2)
    photograph = shoot(np.hstack([one_ball, small]), 0.5)
    ball = find_ball([photograph])
    assert abs(ball.outlines[0].centre_px[0] - 242.6) < 1.0
    np.testing.assert_allclose(ball.others, [(570.0, 200.0, 79.0)], atol=1.5)
    (warning,) = ball.warnings
    told = r"Two balls are in ball\.dng: at \(24[23], 180\) radius 125 and at \(570, 200\) radius 7[89];"
    assert re.match(told, warning)
    assert "Write ball_at = [x, y] to choose." in warning
    chosen = find_ball([photograph], ball_at=(570.0, 210.0))
    np.testing.assert_allclose(chosen.outlines[0].centre_px, (570.0, 200.0), atol=0.5)
    assert not chosen.warnings
    assert len(chosen.others) == 1
    with pytest.raises(OutlineError, match=r"round ball_at = \[700, 390\]"):
        find_ball([photograph], ball_at=(700.0, 390.0))


def test_shifts_are_those_of_the_ball(one_ball):
    moved = np.roll(one_ball, (3, -5), axis=(0, 1))
    ball = find_ball([shoot(one_ball, 0.5), shoot(moved, 0.25)])
    np.testing.assert_allclose(ball.shifts_px, [(0.0, 0.0), (-5.0, 3.0)], atol=0.15)
    first, second = (outline.centre_px for outline in ball.outlines)
    np.testing.assert_allclose(np.subtract(second, first), ball.shifts_px[1])


def test_a_ball_larger_than_the_frame_is_told_from_a_cut_one():
    with pytest.raises(
        OutlineError, match="larger than the frame: its rim lies outside at the left and right"
    ):
        check_in_frame(outline_from_circle(50, 60, 58), (100, 140))
    with pytest.raises(OutlineError, match="given") as error:
        check_in_frame(outline_from_circle(50, 40, 50), (200, 100), given=True)
    assert "give its outline" not in str(error.value)


def test_given_circles():
    outline = outline_from_circle(50.0, 60.0, 20.0)
    np.testing.assert_allclose(np.hypot(*(outline.points_px - (50.0, 60.0)).T), 20.0)
    check_in_frame(outline, (100, 100))
    check_in_frame(outline_from_circle(50, 50, 50.5), (100, 100))  # a sliver
    with pytest.raises(OutlineError, match="top edge"):
        check_in_frame(outline_from_circle(50, 40, 50), (200, 100))
    with pytest.raises(OutlineError, match="positive radius"):
        outline_from_circle(50, 50, -1)


# ---------------------------------------------------------------- reference photographs


@pytest.mark.parametrize("view", [0, 1, 2])
def test_gym_views(shared_dir, view):
    bracket = [read_photograph(shared_dir / f"captures/gym/view{view}_{i}.dng") for i in range(5)]
    outline = find_ball(bracket).outlines[0]
    radius = 5720.267 * np.tan(np.arcsin(0.05 / 0.8))
    assert np.abs(np.array(outline.centre_px) - 400.0).max() < 0.15
    assert abs(sum(outline.semi_axes_px) / 2 - radius) < 0.15


def hand_circles(shared_dir):
    return json.loads((shared_dir / "photos/balls.json").read_text())


def assert_near(outline, circle, share=0.01):
    """Hand circles are true to 2 px; their pixel centres are at integers."""
    x, y, radius = circle
    tolerance = max(2.0, share * radius)
    assert np.hypot(outline.centre_px[0] - x - 0.5, outline.centre_px[1] - y - 0.5) < tolerance
    assert abs(sum(outline.semi_axes_px) / 2 - radius) < tolerance


@pytest.mark.parametrize(
    "name",
    [
        *(
            f"multiview_mirrorball_lobby/LRM_20191113_{n}.jpg"
            for n in ("003812", "003903", "003917", "004136", "004755")
        ),
        "bad_bracket_duplicate/Ball40.jpg",
        "bracket_a6000_office/cp_t320.jpg",
        "bracket_a6000_office/cp_t4000.jpg",
        "bracket_a6400_livingroom/rec1.jpg",
    ],
)
def test_real_photographs(shared_dir, name):
    assert_near(detected(read_photograph(shared_dir / "photos" / name)), hand_circles(shared_dir)[name])


@pytest.mark.long
def test_real_bracket_of_crops_of_different_sizes(shared_dir):
    names = [f"bracket_a6000_office/cp_t{t}.jpg" for t in (20, 320, 1250, 3200)]  # t20 shows hardly any rim
    outlines = find_ball([read_photograph(shared_dir / "photos" / name) for name in names]).outlines
    circles = hand_circles(shared_dir)
    for outline, name in list(zip(outlines, names, strict=True))[1:]:
        assert_near(outline, circles[name])
    assert_near(outlines[0], circles[names[0]], share=0.015)


def test_real_tripod_bracket(shared_dir):
    folder = shared_dir / "photos/bracket_a6400_livingroom"
    outlines = find_ball([read_photograph(folder / f"raw{i}.jpg") for i in (1, 2, 3)]).outlines
    assert_near(outlines[0], (755.6, 549.5, 72.5))


@pytest.mark.parametrize(
    "name",
    [
        "bracket_a6400_livingroom/raw0.jpg",
        "bracket_motog_library/graingerBall_background.jpg",
        "bracket_a6000_office/empty.jpg",
        "multiview_mirrorball_lobby/env.png",
    ],
)
def test_rooms_without_a_ball(shared_dir, name):
    with pytest.raises(OutlineError, match="No mirrored ball"):
        find_ball([read_photograph(shared_dir / "photos" / name)])


def test_a_bracket_of_differing_scale_is_refused(one_ball):
    half = cv2.resize(one_ball, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    with pytest.raises(OutlineError, match="Give the photographs of a view at one size"):
        find_ball([shoot(one_ball, 0.5), shoot(half, 0.5)])
