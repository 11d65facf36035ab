"""Photographs developed for the screen: converted ones keep their codes, raw ones are balanced on the ball."""

from pathlib import Path

import numpy as np
import pytest

from spectral_probe.figures.photograph import developed, write_picture
from spectral_probe.geometry.outline import outline_given
from spectral_probe.model import Photograph
from spectral_probe.photo.read import read_photograph


def test_a_jpeg_or_png_is_shown_as_it_is(tmp_path):
    from PIL import Image

    codes = np.random.default_rng(1).integers(0, 256, (40, 50, 3)).astype(np.uint8)
    Image.fromarray(codes).save(tmp_path / "a.png")
    shown = developed(read_photograph(tmp_path / "a.png"))
    assert np.abs(shown.astype(int) - codes).max() <= 1
    brighter = developed(read_photograph(tmp_path / "a.png"), exposure_ev=1.0)
    assert brighter.mean() > shown.mean() + 20


def photograph(**kind: bool) -> Photograph:
    pixels = np.full((60, 80, 3), (0.02, 0.05, 0.03), np.float32)
    pixels[20:40, 30:50] = (0.2, 0.4, 0.1)
    pixels[0, 0] = np.nan
    return Photograph(Path("a.dng"), pixels, np.zeros((60, 80), bool), **kind)


def test_a_raw_photograph_is_balanced_so_that_the_ball_is_grey():
    picture = developed(photograph(camera_raw=True), outline_given((40, 30, 9)))
    assert picture[30, 40].tolist() == [118, 118, 118]
    whole = developed(photograph(camera_raw=True))
    assert whole[5, 5].tolist() == [118, 118, 118]


def test_radiance_keeps_its_colours():
    picture = developed(photograph(scene_referred_float=True), outline_given((40, 30, 9)))
    assert picture[30, 40, 1] > picture[30, 40, 0] > picture[30, 40, 2]


def test_large_photographs_become_smaller_and_jpeg(tmp_path):
    large = Photograph(Path("a.exr"), np.full((30, 9000, 3), 0.2, np.float32), np.zeros((30, 9000), bool))
    assert developed(large).shape == (14, 4096, 3)
    assert write_picture(tmp_path / "a", np.zeros((10, 10, 3), np.uint8)).suffix == ".png"
    path = write_picture(tmp_path / "b", np.zeros((1000, 2010, 3), np.uint8))
    assert path.suffix == ".jpg"
    assert path.is_file()


@pytest.mark.parametrize("value", [0.0, 1e9])
def test_black_and_overexposed_photographs_are_pictures_too(value):
    even = Photograph(Path("a.dng"), np.full((20, 20, 3), value, np.float32), np.ones((20, 20), bool))
    assert developed(even).shape == (20, 20, 3)
