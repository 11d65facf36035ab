import json

import cv2
import numpy as np
import pytest

from spectral_probe.errors import FileFormatError, SpectralDataError, SpectralProbeError
from spectral_probe.files.region_json import read_region
from spectral_probe.geometry.frames import (
    bearing_to_direction,
    direction_to_bearing,
    panorama_directions,
    panorama_solid_angles,
)
from spectral_probe.model import Region, SpectralPanorama
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.library import daylight, planck
from spectral_probe.spectra.regions import describe, polygon_mask, read_mask, region_mask

HEIGHT, WIDTH = 128, 256
DIRECTIONS = panorama_directions(HEIGHT, WIDTH)


def solid_angle(mask):
    return float((mask * panorama_solid_angles(*mask.shape)).sum())


def panorama_of(levels, valid=None):
    """A panorama of daylight, level by texel, of a filament lamp where the level is negative."""
    levels = np.asarray(levels, np.float32)
    basis = np.stack([daylight(6500.0), planck(2856.0)])
    weights = np.stack([np.maximum(levels, 0), np.maximum(-levels, 0)], -1)
    valid = np.ones(levels.shape, bool) if valid is None else valid
    return SpectralPanorama(
        weights,
        basis[None],
        np.zeros(levels.shape, np.uint8),
        WAVELENGTHS_NM,
        valid,
        valid.astype(np.float32),
    )


LIT = panorama_of(np.ones((HEIGHT, WIDTH)))


# ---------------------------------------------------------------- polygons


def convex(corners):
    """Inside of a convex polygon: on one side of the planes through all its edges."""
    corners = bearing_to_direction(*np.array(corners, float).T)
    normals = np.cross(corners, np.roll(corners, -1, axis=0))
    sides = DIRECTIONS @ normals.T
    return (sides > 0).all(-1) | (sides < 0).all(-1)


@pytest.mark.parametrize(
    "middle", [(40, 10), (0, 0), (359.5, -30), (90, 45), (180, 0), (-90, 0), (17, 88), (200, -89.5), (0, 90)]
)
@pytest.mark.parametrize("count", [3, 4, 9])
def test_convex_polygons_anywhere_on_the_sphere(middle, count):
    seed = bearing_to_direction(*middle)
    across = np.cross(seed, [0.3, -0.5, 0.4])
    across /= np.linalg.norm(across)
    turns = np.arange(count) * 2 * np.pi / count + 0.2
    radius = 0.35
    corners = np.cos(radius) * seed + np.sin(radius) * (
        np.cos(turns)[:, None] * across + np.sin(turns)[:, None] * np.cross(seed, across)
    )
    corners_deg = tuple(zip(*direction_to_bearing(corners), strict=True))
    expected = convex(corners_deg)
    # Inside of all planes on the other side of the sphere is the opposite polygon.
    expected &= DIRECTIONS @ seed > 0
    assert expected.any()
    assert np.array_equal(polygon_mask(corners_deg, HEIGHT, WIDTH), expected)
    assert np.array_equal(polygon_mask(corners_deg[::-1], HEIGHT, WIDTH), expected)


def test_bearings_run_over_the_seam():
    window = polygon_mask(((350, -10), (10, -10), (10, 10), (350, 10)), HEIGHT, WIDTH)
    assert np.array_equal(window, polygon_mask(((-10, -10), (370, -10), (10, 10), (350, 10)), HEIGHT, WIDTH))
    azimuth, _ = direction_to_bearing(DIRECTIONS[window])
    assert set((azimuth[(azimuth > 12) & (azimuth < 348)]).tolist()) == set()
    # The texture's own seam lies at bearing 270.
    seam = polygon_mask(((260, -10), (280, -10), (280, 10), (260, 10)), HEIGHT, WIDTH)
    assert np.array_equal(np.roll(window, -WIDTH // 4, axis=1), seam)


def test_the_area_of_a_spherical_triangle():
    # By Girard: three right angles, an eighth of the sphere, with a corner at the pole.
    assert solid_angle(polygon_mask(((0, 0), (90, 0), (45, 90)), 512, 1024)) == pytest.approx(
        np.pi / 2, rel=2e-3
    )
    assert solid_angle(polygon_mask(((0, 0), (90, 0), (45, -90)), 512, 1024)) == pytest.approx(
        np.pi / 2, rel=2e-3
    )


def test_inside_is_the_smaller_side():
    around = tuple((azimuth, -20.0) for azimuth in range(0, 360, 30))
    mask = polygon_mask(around, HEIGHT, WIDTH)
    assert mask[-1].all()
    assert not mask[0].any()
    assert solid_angle(mask) < 2 * np.pi


def test_of_two_halves_that_with_the_zenith():
    sky = polygon_mask(((0, 0), (90, 0), (180, 0), (270, 0)), HEIGHT, WIDTH)
    assert sky[: HEIGHT // 2].all()
    assert not sky[HEIGHT // 2 :].any()


def test_an_edge_through_the_pole():
    mask = polygon_mask(((0, 60), (180, 60), (90, 45)), HEIGHT, WIDTH)
    azimuth, elevation = direction_to_bearing(DIRECTIONS[mask])
    assert ((azimuth > 0) & (azimuth < 180)).all()
    assert elevation.max() > 89
    assert solid_angle(mask) == pytest.approx(
        solid_angle(polygon_mask(((90, 60), (270, 60), (180, 45)), HEIGHT, WIDTH))
    )


def test_a_meridian_through_a_corner_is_counted_once():
    # Corners on texel centres: whether the outermost column belongs is a matter of rounding, but no other may be lost.
    step = 360 / WIDTH
    for first in (0.5, 63.5, 191.5, 200.5):
        west, east = (first * step, (first + 20) * step)
        mask = polygon_mask(((west, -20), (east, -20), (east, 20), (west, 20)), HEIGHT, WIDTH)
        assert 19 <= mask.any(0).sum() <= 21
        assert mask.sum(0).max() < HEIGHT / 3


def test_a_concave_polygon():
    mask = polygon_mask(((0, 0), (40, 0), (40, 30), (20, 5), (0, 30)), HEIGHT, WIDTH)

    def inside(azimuth, elevation):
        return mask[
            np.unravel_index(np.argmax(DIRECTIONS @ bearing_to_direction(azimuth, elevation)), mask.shape)
        ]

    assert inside(5, 15)
    assert inside(35, 15)
    assert not inside(20, 15)


def crossed_along_arcs(corners, start):
    """Whether the arc from a direction to each texel crosses the edges an odd number of times."""
    odd = np.zeros(DIRECTIONS.shape[:2], bool)
    arcs = np.cross(start, DIRECTIONS)

    def within(point, first, last, normal):
        before = (np.cross(first, point) * normal).sum(-1) > 0
        return before & ((np.cross(point, last) * normal).sum(-1) > 0)

    for first, last in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        normal = np.cross(first, last)
        meeting = np.cross(normal, arcs)
        for point in (meeting, -meeting):
            odd ^= within(point, first, last, normal) & within(point, start, DIRECTIONS, arcs)
    return odd


@pytest.mark.parametrize("seed", range(20))
def test_polygons_of_any_shape_against_crossings_along_arcs(seed):
    """Stars that hold poles, span more than a hemisphere, or cross themselves."""
    rng = np.random.default_rng(seed)
    middle = [0, 0, 1.0] if seed % 4 == 0 else rng.standard_normal(3)
    middle = middle / np.linalg.norm(middle)
    across = np.cross(middle, [0.3, 0.2, 0.9])
    across /= np.linalg.norm(across)
    count = rng.integers(3, 14)
    turns = np.sort(rng.random(count)) * 2 * np.pi
    radius = np.radians(rng.uniform(5, [40, 85, 150][seed % 3], count))
    corners = np.cos(radius)[:, None] * middle + np.sin(radius)[:, None] * (
        np.cos(turns)[:, None] * across + np.sin(turns)[:, None] * np.cross(middle, across)
    )
    if seed % 5 == 0:
        rng.shuffle(corners)
    expected = crossed_along_arcs(corners, rng.standard_normal(3))
    if solid_angle(expected) > 2 * np.pi:
        expected = ~expected
    corners_deg = tuple(zip(*direction_to_bearing(corners), strict=True))
    assert np.array_equal(polygon_mask(corners_deg, HEIGHT, WIDTH), expected)


def test_opposite_corners():
    with pytest.raises(SpectralDataError, match="Corners 1 and 2 of the polygon lie opposite each other"):
        polygon_mask(((0, 0), (180, 0), (90, 50)), HEIGHT, WIDTH)


# ---------------------------------------------------------------- masks


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
@pytest.mark.parametrize("scale", [1, 2, 0.5])
def test_masks_of_any_size_and_depth(tmp_path, kind, scale):
    expected = np.zeros((HEIGHT, WIDTH), bool)
    expected[20:60, 40:90] = True
    picture = cv2.resize(expected.astype(np.uint8), None, fx=scale, fy=scale, interpolation=cv2.INTER_NEAREST)
    cv2.imwrite(str(tmp_path / "m.png"), picture.astype(kind) * np.iinfo(kind).max)
    assert np.array_equal(region_mask(Region(mask=tmp_path / "m.png"), LIT), expected)


def test_opacity_and_colours_of_a_mask(tmp_path):
    picture = np.zeros((64, 128, 4), np.uint8)
    picture[:10] = 255
    picture[10:20] = (255, 255, 255, 0)  # white, but transparent
    picture[20:30] = (0, 0, 0, 255)
    cv2.imwrite(str(tmp_path / "m.png"), picture)
    assert np.flatnonzero(read_mask(tmp_path / "m.png", 64, 128).all(1)).tolist() == list(range(10))


# ---------------------------------------------------------------- files


@pytest.mark.parametrize(
    ("text", "region"),
    [
        ('{"seed_deg": [370, -5]}', Region(seed_deg=(370, -5))),
        ('{"polygon_deg": [[0, 0], [10, 0], [5, 10]]}', Region(polygon_deg=((0, 0), (10, 0), (5, 10)))),
    ],
)
def test_region_files(tmp_path, text, region):
    (tmp_path / "region.json").write_text(text)
    assert read_region(tmp_path / "region.json") == region


def test_a_mask_lies_beside_its_file(tmp_path):
    (tmp_path / "region.json").write_text(json.dumps({"mask": "fenêtre.png"}), encoding="utf-8")
    assert read_region(tmp_path / "region.json").mask == tmp_path / "fenêtre.png"


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("{", "r.json is not valid JSON."),
        ("[]", "A region is one of"),
        ("{}", "A region is one of"),
        ('{"seed_deg": [1, 2], "mask": "m.png"}', "A region is one of"),
        ('{"polygon": [[1, 2]]}', '"polygon" is not as it should be'),
        ('{"mask": 3}', '"mask" is not as it should be'),
        ('{"seed_deg": [1, NaN]}', "[1, NaN] is no bearing"),
        ('{"seed_deg": [1, 95]}', "elevation 95 is not between -90 and 90"),
        ('{"seed_deg": "north"}', '"north" is no bearing'),
        ('{"seed_deg": [true, 1]}', "is no bearing"),
        ('{"polygon_deg": [[1, 2], [3, 4]]}', "needs three corners or more"),
        ('{"polygon_deg": [[1, 2], [3, 4], [5]]}', "[5] is no bearing"),
    ],
)
def test_files_that_describe_no_region(tmp_path, text, line):
    (tmp_path / "r.json").write_text(text)
    with pytest.raises(FileFormatError) as caught:
        read_region(tmp_path / "r.json")
    assert "r.json" in str(caught.value)
    assert line in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_file(tmp_path):
    with pytest.raises(FileFormatError, match="There is no region file"):
        read_region(tmp_path / "r.json")


# ---------------------------------------------------------------- regions that select nothing


def test_regions_that_select_nothing(tmp_path):
    black = np.ones((HEIGHT, WIDTH))
    black[:40] = 0
    valid = np.ones((HEIGHT, WIDTH), bool)
    valid[-30:] = False
    panorama = panorama_of(black, valid)
    cv2.imwrite(str(tmp_path / "black.png"), np.zeros((64, 128), np.uint8))
    cv2.imwrite(str(tmp_path / "square.png"), np.zeros((64, 64), np.uint8))
    (tmp_path / "text.png").write_text("no picture")
    for region, line in (
        (Region(polygon_deg=((0, 0), (0.1, 0), (0, 0.1))), "selects nothing"),
        (Region(polygon_deg=((0, 60), (90, 60), (45, 80))), "is black"),
        (Region(polygon_deg=((0, -60), (90, -60), (45, -80))), "no view saw"),
        (Region(mask=tmp_path / "black.png"), "mask black.png) selects nothing"),
        (Region(mask=tmp_path / "square.png"), "square.png is 64 x 64 pixels"),
        (Region(mask=tmp_path / "lost.png"), "There is no mask"),
        (Region(mask=tmp_path / "text.png"), "cannot be read as a picture"),
        (Region(seed_deg=(0, 70)), "There is no light at 0,70"),
        (Region(seed_deg=(0, -80)), "No view saw the direction 0,-80"),
        (Region(seed_deg=(0, float("nan"))), "not a number"),
        (Region(), "exactly one"),
    ):
        with pytest.raises(SpectralProbeError) as caught:
            region_mask(region, panorama)
        assert line in str(caught.value)
        assert "\n" not in str(caught.value)


def test_regions_in_words():
    assert describe(Region(seed_deg=(12, -3.5))) == "grown from 12,-3.5"
