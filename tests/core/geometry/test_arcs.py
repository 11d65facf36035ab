"""Great circles and outlines as lines of an equirectangular picture."""

import numpy as np
import pytest

from spectral_probe.geometry.arcs import bearing_to_picture, mask_outline, picture_to_bearing, polygon_lines
from spectral_probe.geometry.frames import bearing_to_direction, direction_to_equirectangular
from spectral_probe.spectra.regions import polygon_mask


def test_the_picture_is_blenders_equirectangular():
    random = np.random.default_rng(1)
    azimuth, elevation = random.uniform(0, 360, 50), random.uniform(-89, 89, 50)
    points = bearing_to_picture(azimuth, elevation)
    texels = direction_to_equirectangular(bearing_to_direction(azimuth, elevation), 100, 200)
    assert points[:, 0] * 200 == pytest.approx(texels[:, 0])
    assert (1 - points[:, 1]) * 100 == pytest.approx(texels[:, 1])
    back = picture_to_bearing(points)
    assert back[0] == pytest.approx(azimuth)
    assert back[1] == pytest.approx(elevation)


def test_edges_are_great_circles():
    """Every point of an edge lies in the plane of its two corners."""
    corners = [(20.0, 60.0), (140.0, 50.0)]
    lines = polygon_lines(corners, closed=False)
    first, second = (bearing_to_direction(*corner) for corner in corners)
    directions = bearing_to_direction(*picture_to_bearing(lines.reshape(-1, 2)))
    assert np.abs(directions @ np.cross(first, second)).max() < 1e-9
    assert picture_to_bearing(lines[:, 0])[1].max() > 65  # higher than both: it bows towards the pole


def test_no_line_runs_across_the_picture_where_the_polygon_crosses_its_edge():
    lines = polygon_lines([(250.0, -10.0), (290.0, -10.0), (290.0, 15.0), (250.0, 15.0)])
    assert np.abs(lines[:, 1, 0] - lines[:, 0, 0]).max() < 0.02
    on_edge = {0.0, 1.0} & set(lines[..., 0].ravel().tolist())
    assert on_edge == {0.0, 1.0}
    assert lines.min() >= 0.0
    assert lines.max() <= 1.0


def test_a_polygon_round_the_pole_passes_every_bearing():
    lines = polygon_lines([(0.0, 60.0), (120.0, 60.0), (240.0, 60.0)])
    covered = np.abs(lines[:, 1, 0] - lines[:, 0, 0]).sum()
    assert covered == pytest.approx(1.0, abs=1e-9)


def test_an_edge_over_the_zenith_is_drawn_on_both_sides():
    lines = polygon_lines([(90.0, 80.0), (270.0 - 1e-7, 80.0)], closed=False)
    assert lines[..., 1].max() > 0.99
    assert np.isfinite(lines).all()


def test_opposite_corners_have_no_edge_and_one_corner_has_none():
    assert polygon_lines([(0.0, 10.0), (180.0, -10.0)], closed=False).shape == (0, 2, 2)
    assert polygon_lines([(5.0, 5.0)]).shape == (0, 2, 2)
    assert polygon_lines([(5.0, 5.0), (5.0, 5.0)], closed=False).shape == (0, 2, 2)


def test_the_outline_of_a_polygons_texels_lies_on_its_edges():
    corners = ((80.0, -10.0), (110.0, -10.0), (110.0, 20.0), (80.0, 20.0))
    outline = mask_outline(polygon_mask(corners, 180, 360)).reshape(-1, 2)
    edges = polygon_lines(corners, step_deg=0.1).reshape(-1, 2)
    scale = np.array([360.0, 180.0])  # degrees
    apart = np.linalg.norm((outline[:, None] - edges) * scale, axis=-1).min(1)
    assert apart.max() < 1.0  # a texel


def test_an_outline_over_the_seam_is_not_drawn_between_its_halves():
    mask = np.zeros((4, 8), bool)
    mask[1:3, [7, 0]] = True
    places = np.unique(mask_outline(mask)[..., 0])
    upright = [line for line in mask_outline(mask).tolist() if line[0][0] == line[1][0]]
    assert {line[0][0] for line in upright} == {1 / 8, 7 / 8}
    assert places.tolist() == [0.0, 1 / 8, 7 / 8, 1.0]
