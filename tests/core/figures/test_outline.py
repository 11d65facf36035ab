"""The outline drawn over a photograph lies where the ball is."""

from pathlib import Path

import numpy as np
import pytest

from spectral_probe.figures.outline import outline_picture
from spectral_probe.model import Outline, Photograph


def photograph(width: int) -> Photograph:
    """A dark frame with a greenish disc of 0.4 of the width."""
    height = width * 3 // 4
    rows, columns = np.mgrid[:height, :width] + 0.5
    disc = np.hypot(columns - width / 2, rows - height / 2) < 0.2 * width
    pixels = np.where(disc[..., None], np.array([0.2, 0.4, 0.3]), 0.01).astype(np.float32)
    return Photograph(Path("p.dng"), pixels, np.zeros((height, width), bool))


def outline(width: int) -> Outline:
    centre = (width / 2, width * 3 / 8)
    return Outline(centre, (0.2 * width, 0.2 * width), 0.0, np.empty((0, 2)), 0.1)


@pytest.mark.parametrize("width", [400, 3200])
def test_the_line_lies_on_the_rim_at_any_size(width):
    picture = outline_picture(photograph(width), outline(width), max_width_px=800)
    shown_width = min(width, 800)
    assert picture.shape == (shown_width * 3 // 4, shown_width, 3)
    red, green = picture[..., 0].astype(int), picture[..., 1].astype(int)
    rows, columns = np.nonzero(red - green > 120)
    radius_px = np.hypot(columns + 0.5 - shown_width / 2, rows + 0.5 - shown_width * 3 / 8)
    on_rim = radius_px[radius_px > 0.1 * shown_width]
    assert np.mean(on_rim) == pytest.approx(0.2 * shown_width, abs=0.15)
    assert len(on_rim) > 2 * np.pi * 0.2 * shown_width * 0.7


def test_the_ball_is_shown_as_a_middle_grey():
    picture = outline_picture(photograph(400), outline(400))
    assert picture[130, 200].tolist() == [118, 118, 118]
