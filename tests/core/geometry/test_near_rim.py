"""An outline drawn by hand near the rim finds it; elsewhere it is used as it is, and that is said."""

from pathlib import Path

import numpy as np
import pytest

from spectral_probe.errors import OutlineError
from spectral_probe.geometry.near_rim import find_ball_near
from spectral_probe.geometry.outline import outline_given
from spectral_probe.model import Photograph, ViewSettings
from spectral_probe.view import locate_ball

CENTRE_PX, RADIUS_PX = np.array([151.3, 118.6]), 70.4


@pytest.fixture(scope="module")
def photograph() -> Photograph:
    """A dull ball with a pattern before a grey wall: its rim is a step, which mirrors do not have."""
    rows, columns = np.mgrid[:240, :300] + 0.5
    away = np.hypot(columns - CENTRE_PX[0], rows - CENTRE_PX[1])
    inside = np.clip(RADIUS_PX - away + 0.5, 0.0, 1.0)[..., None]
    pattern = 0.45 + 0.15 * np.sin(columns / 11) * np.cos(rows / 13)
    noise = np.random.default_rng(3).normal(0.0, 1e-3, (240, 300, 3))
    pixels = inside * pattern[..., None] + (1 - inside) * 0.12 + noise
    return Photograph(Path("ball.dng"), pixels.astype(np.float32), np.zeros((240, 300), bool))


@pytest.mark.parametrize("off", [(0.06, -0.05, 0.0), (-0.05, 0.02, -0.07)])
def test_an_outline_within_a_tenth_of_the_radius_finds_the_rim(photograph, off):
    start = (*(CENTRE_PX + RADIUS_PX * np.array(off[:2])), RADIUS_PX * (1 + off[2]))
    found = find_ball_near([photograph], outline_given(start))
    outline = found.outlines[0]
    assert found.warnings == ()
    np.testing.assert_allclose(outline.centre_px, CENTRE_PX, atol=0.35)
    np.testing.assert_allclose(outline.semi_axes_px, RADIUS_PX, atol=0.35)


def test_without_a_rim_near_it_the_outline_is_used_as_it_is(photograph):
    given = outline_given((60.0, 60.0, 25.0))
    found = find_ball_near([photograph], given)
    assert found.outlines == (given,)
    assert found.warnings == ("No rim lies near the outline drawn in ball.dng: it is used as it is.",)


def test_a_view_says_whether_the_rim_is_meant_or_the_outline_itself(photograph):
    start = (CENTRE_PX[0] + 3.0, CENTRE_PX[1], RADIUS_PX)
    as_given = locate_ball([photograph], ViewSettings((photograph.path,), outline=start))
    snapped = locate_ball([photograph], ViewSettings((photograph.path,), outline=start, snap_outline=True))
    assert as_given.outlines[0].centre_px == start[:2]
    assert abs(snapped.outlines[0].centre_px[0] - CENTRE_PX[0]) < 0.35


def test_no_photograph_and_an_outline_without_size_are_refused(photograph):
    with pytest.raises(OutlineError, match="no photograph"):
        find_ball_near([], outline_given((10, 10, 5)))
    with pytest.raises(OutlineError, match="positive radius"):
        outline_given((10, 10, 5, 0, 0))
    with pytest.raises(OutlineError, match="leaves the frame"):
        find_ball_near([photograph], outline_given((5.0, 5.0, 30.0)))
