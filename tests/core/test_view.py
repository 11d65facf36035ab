"""Views through filters: the ball is found in them, or taken to be where it was without the filter."""

from dataclasses import replace

import numpy as np
import pytest

from spectral_probe.files.image_exr import write_rgb
from spectral_probe.model import Capture, ViewSettings
from spectral_probe.view import measure_view


@pytest.fixture(scope="module")
def partner(three_lamps, tmp_path_factory):
    path = three_lamps.write(tmp_path_factory.mktemp("view") / "plain.exr")
    settings = ViewSettings((path,))
    capture = Capture((settings,), three_lamps.settings)
    return capture, measure_view(capture, settings)


def test_the_ball_is_found_through_the_filter(three_lamps, green_filter, partner, tmp_path):
    """Where the tripod stood still its outline is the very same; where it was touched it is found where it is now."""
    capture, without = partner
    picture = three_lamps.photograph(transmittance=green_filter, seed=1)
    for moved in (0, 3):
        write_rgb(tmp_path / "green.exr", np.roll(picture, moved, axis=1))
        settings = replace(without.settings, photos=(tmp_path / "green.exr",), filter="green")
        view = measure_view(capture, settings, partner=without)
        assert not view.remarks
        assert (view.outline is without.outline) == (moved == 0)
        x, y = without.outline.centre_px
        assert view.outline.centre_px == pytest.approx((x + moved, y), abs=0.7)


def test_where_it_is_too_dark_to_be_found_it_is_where_it_was(partner, tmp_path):
    capture, without = partner
    dark = np.random.default_rng(0).normal(1e-3, 1e-3, (200, 200, 3)).clip(0).astype(np.float32)
    write_rgb(tmp_path / "dark.exr", dark)
    settings = replace(without.settings, photos=(tmp_path / "dark.exr",), filter="green")
    view = measure_view(capture, settings, partner=without)
    assert view.outline is without.outline
    assert "Too dark through the filter" in view.remarks[0]


def test_another_round_thing_is_not_taken_for_the_ball(three_lamps, partner, tmp_path):
    """The same picture at half the size, as if a plate were seen: the ball has not shrunk."""
    capture, without = partner
    small = np.zeros((200, 200, 3), np.float32)
    picture = three_lamps.photograph()
    small[:] = picture[0, 100]
    small[90:190, 90:190] = picture[::2, ::2]
    write_rgb(tmp_path / "small.exr", small)
    settings = replace(without.settings, photos=(tmp_path / "small.exr",), filter="green")
    view = measure_view(capture, settings, partner=without)
    assert view.outline is without.outline
    assert "something else seemed to be the ball" in view.remarks[0]
