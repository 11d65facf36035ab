"""Where exposures come from, and what is refused."""

from pathlib import Path

import numpy as np
import pytest

from spectral_probe.errors import PhotographError
from spectral_probe.model import Exposure, Photograph, ViewSettings
from spectral_probe.photo.exposure import resolve_exposures


def photograph(name="v0_1.png", exposure=None, radiance=False):
    pixels = np.zeros((2, 2, 3), np.float32)
    return Photograph(Path(name), pixels, np.zeros((2, 2), bool), exposure, scene_referred_float=radiance)


def view(**settings):
    return ViewSettings(photos=(), **settings)


def test_exif_is_the_default():
    known = Exposure(0.01, 400, 8)
    assert resolve_exposures([photograph(exposure=known)], view()) == [known]


def test_the_capture_file_wins_value_by_value():
    shots = [photograph(exposure=Exposure(0.01, 400, 8)), photograph(exposure=Exposure(0.02, 400, 8))]
    resolved = resolve_exposures(shots, view(exposures_s=(1.0, 2.0), f_number=(4.0,)))
    assert resolved == [Exposure(1.0, 400, 4), Exposure(2.0, 400, 4)]


def test_radiance_needs_no_exposure():
    assert resolve_exposures([photograph("a.exr", radiance=True)], view())[0].relative == 1.0


def test_a_photograph_without_exposure_is_named():
    shots = [photograph(exposure=Exposure(0.01)), photograph("v0_1.png")]
    with pytest.raises(
        PhotographError, match=r"^v0_1\.png says no exposure time\. Add exposures_s to its view"
    ):
        resolve_exposures(shots, view())


@pytest.mark.parametrize("absurd", [Exposure(1e9), Exposure(0.01, iso=0.0), Exposure(0.01, f_number=1e6)])
def test_what_no_camera_can_state_is_as_good_as_absent(absurd):
    with pytest.raises(PhotographError, match=r"^v0_1\.png states .*, which cannot be\. Add exposures_s"):
        resolve_exposures([photograph(exposure=absurd)], view())
    assert resolve_exposures([photograph(exposure=absurd)], view(exposures_s=(0.5,))) == [Exposure(0.5)]


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"exposures_s": (1.0,)}, "exposures_s has 1 values for 2 photographs"),
        ({"exposures_s": (1.0, 0.0)}, "exposures_s holds a value that is not positive"),
        ({"exposures_s": (1.0, 2.0), "iso": (100.0, float("nan"))}, "iso holds a value"),
        ({"exposures_s": (1.0, 2.0), "f_number": (1.0, 2.0, 4.0)}, "f_number has 3 values"),
    ],
)
def test_bad_lists_are_refused(settings, message):
    with pytest.raises(PhotographError, match=message):
        resolve_exposures([photograph(), photograph()], view(**settings))
