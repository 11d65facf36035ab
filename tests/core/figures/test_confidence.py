import matplotlib as mpl
import numpy as np
import pytest

from spectral_probe.figures.confidence import TICKS, confidence_preview, on_scale
from spectral_probe.model import SpectralPanorama
from spectral_probe.spectra.grid import WAVELENGTHS_NM

COLOURS = mpl.colormaps["viridis"]


def panorama(confidence, valid):
    height, width = confidence.shape
    return SpectralPanorama(
        np.ones((height, width, 1), np.float32),
        np.ones((1, 1, 61)),
        np.zeros((height, width), np.uint8),
        WAVELENGTHS_NM,
        valid,
        confidence.astype(np.float32),
    )


def is_grey(pixels):
    return (pixels.max(-1) == pixels.min(-1)) & (pixels[..., 0] >= 140)


@pytest.mark.parametrize("width", [64, 700, 3000])
def test_colours_are_those_of_the_scale_and_unseen_directions_grey(width):
    height = width // 2
    confidence = np.where(np.arange(width) < width // 2, 0.9, 0.99)[None].repeat(height, 0)
    confidence[height // 2 :] = np.nan
    valid = np.ones((height, width), bool)
    valid[height // 2 :] = False
    picture = confidence_preview(panorama(confidence, valid))
    shown_width = {64: 640, 700: 700, 3000: 2048}[width]
    assert picture.shape[1] == shown_width
    assert shown_width // 2 < len(picture) < shown_width // 2 + 0.15 * shown_width + 10
    for column, value in ((0.1, 0.9), (0.9, 0.99)):
        pixel = picture[shown_width // 8, int(column * shown_width)]
        np.testing.assert_allclose(pixel, COLOURS(on_scale(np.array(value)), bytes=True)[:3], atol=2)
    assert is_grey(picture[shown_width // 4 + 3 : shown_width // 2]).all()
    assert len(np.unique(picture[shown_width // 4 + 3 : shown_width // 2, ..., 0])) == 2  # stripes


def test_the_scale_rises_and_its_ends_hold_everything():
    positions = on_scale(np.array([-1.0, 0.0, *TICKS, 1.0, 2.0]))
    assert positions[0] == positions[1] == 0
    assert positions[-1] == positions[-2] == pytest.approx(1)
    assert (np.diff(positions[1:-1]) > 0).all()


def test_not_seen_is_explained_only_where_there_is_any():
    confidence = np.full((400, 800), 0.5)
    whole = confidence_preview(panorama(confidence, np.ones((400, 800), bool)))[400:]
    part = confidence_preview(panorama(confidence, np.eye(400, 800, dtype=bool)))[400:]
    assert whole.shape == part.shape
    assert (part != 255).any(-1).sum() > (whole != 255).any(-1).sum() + 100


def test_only_grey_is_drawn_where_nothing_was_seen():
    picture = confidence_preview(panorama(np.zeros((32, 64)), np.zeros((32, 64), bool)))
    assert is_grey(picture[:320]).all()
