"""Windows and lamps grown from a seed, in rooms whose truth is known."""

import cv2
import numpy as np
import pytest

from spectral_probe.geometry.frames import bearing_to_direction, panorama_directions, panorama_solid_angles
from spectral_probe.geometry.sphere import blurred
from spectral_probe.model import Region, SpectralPanorama
from spectral_probe.spectra.colorimetry import spectra_to_xyz
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.library import daylight, planck
from spectral_probe.spectra.regions import polygon_mask, region_mask

HEIGHT, WIDTH = 256, 512


def window(azimuth, elevation, wide=24.0, high=16.0):
    """A rectangle of great circles round a direction: what a window on a wall straight ahead is."""
    seed = bearing_to_direction(azimuth, elevation)
    right = bearing_to_direction(azimuth + 90, 0)
    up = np.cross(right, seed)
    corners = [
        seed + x * np.tan(np.radians(wide / 2)) * right + y * np.tan(np.radians(high / 2)) * up
        for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    x, y, z = np.array(corners).T
    bearings = np.degrees(np.arctan2(x, y)), np.degrees(np.arctan2(z, np.hypot(x, y)))
    return polygon_mask(tuple(zip(*bearings, strict=True)), HEIGHT, WIDTH)


def room(bright, wall=0.05, lamps=None, noise=0.0, blur_deg=0.0):
    """Daylight where `bright` (H, W) says how much, walls lit by it, and filament lamps."""
    levels = np.stack([np.maximum(bright, wall), np.zeros_like(bright) if lamps is None else lamps], -1)
    if lamps is not None:
        levels[lamps > 0, 0] = 0
    levels = blurred(levels.astype(np.float32), np.radians(blur_deg)) if blur_deg else levels
    levels = levels * (1 + noise * np.random.default_rng(7).standard_normal(levels.shape))
    basis = np.stack([daylight(6500.0), planck(2856.0)])
    whole = np.ones(bright.shape, bool)
    return SpectralPanorama(
        np.maximum(levels, 0).astype(np.float32),
        basis[None],
        np.zeros(bright.shape, np.uint8),
        WAVELENGTHS_NM,
        whole,
        whole.astype(np.float32),
    )


def overlap(mask, truth):
    """Solid angle of the intersection over that of the union."""
    share = panorama_solid_angles(*mask.shape)
    return float((share * (mask & truth)).sum() / (share * (mask | truth)).sum())


def grown(panorama, azimuth, elevation):
    return region_mask(Region(seed_deg=(azimuth, elevation)), panorama)


@pytest.mark.parametrize("place", [(30, 10), (0, 0), (270, 0), (268, -20), (90, 78), (0, 89), (45, -85)])
def test_a_window_anywhere(place):
    truth = window(*place)
    assert np.array_equal(grown(room(truth * 1.0), *place), truth)


@pytest.mark.parametrize("offset", [(0, 0), (8, 5), (-11, -6)])
def test_a_blurred_noisy_window(offset):
    truth = window(30, 10)
    panorama = room(truth * 1.0, blur_deg=0.6, noise=0.05)
    found = grown(panorama, 30 + offset[0], 10 + offset[1])
    assert (found | ~truth).all()
    assert overlap(found, truth) > 0.8  # its blurred rim belongs to it
    rim = cv2.dilate(truth.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    assert not (found & ~rim).any()


def test_no_bright_rim_is_left():
    truth = window(30, 10)
    panorama = room(truth * 1.0, blur_deg=0.6)
    left = panorama.weights[..., 0][~grown(panorama, 30, 10)]
    assert left.max() < 0.2


def test_glazing_bars_do_not_divide_it_even_under_the_seed():
    truth = window(270, 20, wide=30, high=30)
    bars = np.zeros_like(truth)
    bars[:, ::9] = bars[::9] = True
    panorama = room(np.where(bars, 0.02, truth * 1.0))
    rows, columns = np.nonzero(truth & bars)
    direction = panorama_directions(HEIGHT, WIDTH)[rows[len(rows) // 2], columns[len(rows) // 2]]
    azimuth = np.degrees(np.arctan2(direction[0], direction[1]))
    elevation = np.degrees(np.arcsin(direction[2]))
    assert overlap(grown(panorama, azimuth, elevation), truth) > 0.9


def test_two_windows_stay_two():
    left, right = window(30, 10), window(58, 10)
    panorama = room((left | right) * 1.0)
    assert np.array_equal(grown(panorama, 30, 10), left)
    assert np.array_equal(grown(panorama, 58, 10), right)


@pytest.mark.parametrize("wall", [0.3, 0.6, 0.75])
def test_a_bright_wall_of_the_same_light_is_not_entered(wall):
    truth = window(30, 10)
    lit = window(30, 0, wide=90, high=70) * wall
    found = grown(room(np.maximum(truth * 1.0, lit), noise=0.01), 30, 10)
    assert overlap(found, truth) > 0.97


def test_a_sky_that_gets_darker_and_a_tree_before_it():
    truth = window(30, 10)
    shade = np.linspace(1.0, 0.6, HEIGHT)[:, None] ** 3
    tree = window(32, 10, wide=5, high=6)
    found = grown(room(np.where(tree, 0.1, truth * shade)), 22, 14)
    assert overlap(found, truth) > 0.98


def test_a_lamp_before_a_window_is_left_out_and_found_itself():
    truth, bulb = window(30, 10), window(34, 12, wide=4, high=4)
    panorama = room(truth * 1.0, lamps=bulb * 30.0)
    assert np.array_equal(grown(panorama, 24, 10), truth & ~bulb)
    assert np.array_equal(grown(panorama, 34, 12), bulb)


def test_the_sun_in_a_window_belongs_to_it():
    truth, sun = window(30, 10), window(26, 13, wide=3, high=3)
    panorama = room(np.where(sun, 300.0, truth * 1.0))
    assert np.array_equal(grown(panorama, 36, 6), truth)


def test_a_lamp_of_one_texel():
    bulb = np.zeros((HEIGHT, WIDTH), bool)
    bulb[60, 100] = True
    panorama = room(np.zeros((HEIGHT, WIDTH)), lamps=bulb * 500.0)
    direction = panorama_directions(HEIGHT, WIDTH)[60, 100]
    azimuth, elevation = (
        np.degrees(np.arctan2(direction[0], direction[1])),
        np.degrees(np.arcsin(direction[2])),
    )
    assert np.array_equal(grown(panorama, azimuth + 0.8, elevation), bulb)


def test_a_ring_lamp_keeps_its_middle_free():
    ring = window(30, 10, 20, 20) & ~window(30, 10, 12, 12)
    found = grown(room(np.zeros(ring.shape), lamps=ring * 100.0), 30, 18)
    assert np.array_equal(found, ring)


def test_the_windows_of_a_rendered_gym(shared_dir):
    """Seeds in each window of a hall find that window, whose truth is what is bright and not of a filament lamp."""
    with np.load(shared_dir / "captures" / "gym" / "truth" / "truth.npz") as file:
        spectra = np.roll(file["panorama"].astype(np.float32), -64, axis=1)  # to Blender's frame
    basis = np.linalg.svd(spectra.reshape(-1, 61), full_matrices=False)[2][:8].astype(float)
    whole = np.ones(spectra.shape[:2], bool)
    panorama = SpectralPanorama(
        (spectra @ basis.T).astype(np.float32),
        basis[None],
        np.zeros(whole.shape, np.uint8),
        WAVELENGTHS_NM,
        whole,
        whole.astype(np.float32),
    )
    xyz = spectra_to_xyz(spectra)
    bright = (xyz[..., 1] > 66.4) & (xyz[..., 0] < 2 * xyz[..., 2])  # thresholds of the truth's own case.json
    for azimuth, elevation in ((83.9, 14.8), (96.9, 13.7), (69.5, 13.5), (110.3, 13.3)):
        found = region_mask(Region(seed_deg=(azimuth, elevation)), panorama)
        count, labels = cv2.connectedComponents(bright.astype(np.uint8))
        truth = labels == np.bincount(labels[found], minlength=count)[1:].argmax() + 1
        assert overlap(found, truth) > 0.9
