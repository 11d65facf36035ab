import numpy as np
import pytest
from PIL import Image

from spectral_probe.figures.display import KNEE, exposure_for_key, exposure_for_white, tone_map, write_png
from spectral_probe.spectra.colorimetry import rec709_to_xyz


def decoded(picture):
    """Linear values of sRGB pixels (IEC 61966-2-1)."""
    encoded = picture / 255.0
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def test_below_the_knee_colours_are_exact():
    rgb = np.random.default_rng(3).uniform(0, KNEE / 2, (50, 3))
    shown = tone_map(rec709_to_xyz(rgb), 2.0)
    np.testing.assert_allclose(decoded(shown), 2 * rgb, atol=0.005)  # 8 bits


def test_highlights_roll_off_without_a_break_and_never_darken():
    levels = np.linspace(0, 20, 4001)[:, None] * np.array([1.0, 0.7, 0.4])
    shown = tone_map(rec709_to_xyz(levels), 1.0).astype(int)
    assert (np.diff(shown, axis=0) >= 0).all()
    assert np.diff(shown, axis=0)[50:].max() <= 3
    assert (np.diff(shown, axis=1) <= 0).all()  # an orange stays an orange
    assert shown[-1].min() > shown[400].min()  # and pales with brightness


def test_colours_out_of_gamut_keep_their_luminance():
    inside = tone_map(np.array([0.05, 0.2, 0.05]), 1.0)
    luminance = decoded(inside) @ [0.2126, 0.7152, 0.0722]
    assert luminance == pytest.approx(0.2, abs=0.004)
    assert inside.argmax() == 1


def test_no_number_is_black():
    assert not tone_map(np.array([[np.nan, 1.0, 1.0], [np.inf, 1.0, 1.0], [-1.0, -1.0, -1.0]]), 1.0).any()


def test_exposures():
    luminance = np.full((10, 10), 2.0)
    luminance[0, :3] = 1e5  # lamps
    everywhere = np.ones((10, 10), bool)
    assert exposure_for_key(luminance, everywhere) == pytest.approx(0.09)
    assert exposure_for_key(np.zeros((2, 2)), np.ones((2, 2), bool)) == 1.0
    weights = np.zeros((10, 10))
    weights[0, 0] = 1.0
    assert exposure_for_key(luminance, everywhere, weights) == pytest.approx(0.18e-5)
    assert exposure_for_key(luminance, luminance > 1e4) == pytest.approx(0.18e-5)
    white = tone_map(rec709_to_xyz(np.full(3, 7.0)), exposure_for_white(7.0))
    np.testing.assert_allclose(decoded(white), KNEE, atol=0.01)


def test_png_holds_the_pixels(tmp_path):
    picture = np.random.default_rng(1).integers(0, 256, (12, 20, 3), dtype=np.uint8)
    write_png(tmp_path / "new" / "preview.png", picture)
    with Image.open(tmp_path / "new" / "preview.png") as read:
        assert read.mode == "RGB"
        np.testing.assert_array_equal(np.asarray(read), picture)
