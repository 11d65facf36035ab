"""Views through filters: which view they belong to, and which channels they add."""

from pathlib import Path

import numpy as np
import pytest

from spectral_probe.errors import SpectralProbeError
from spectral_probe.filters import filter_sets
from spectral_probe.model import ViewSettings
from spectral_probe.spectra.camera import camera_sensitivities
from spectral_probe.spectra.grid import WAVELENGTHS_NM

PHOTO = (Path("a.dng"),)


@pytest.fixture
def curve(tmp_path):
    def write(name, transmittance):
        path = tmp_path / name
        rows = [f"{nm:g},{value:.9g}" for nm, value in zip(WAVELENGTHS_NM, transmittance, strict=True)]
        path.write_text("wavelength_nm,transmittance\n" + "\n".join(rows))
        return path

    return write


def test_views_of_the_same_angles_belong_together(curve, green_filter):
    green, red = curve("green.csv", green_filter), curve("red.csv", np.linspace(0, 0.8, 61))
    views = [
        ViewSettings(PHOTO, 120.0, 5.0, filter=green),
        ViewSettings(PHOTO, 0.0),
        ViewSettings(PHOTO, 120.00001, 5.0),  # Blender keeps radians
        ViewSettings(PHOTO, 360.0, filter=red),
        ViewSettings(PHOTO, -240.0, 5.0, filter=red),
    ]
    sets = filter_sets(views)
    assert sets.partner == (2, 1, 2, 1, 2)
    assert sets.group == (1, 0, 0, 2, 2)
    assert sets.leaders == (1, 2)
    assert sets.transmittances.shape == (3, 61)
    camera = camera_sensitivities("Nikon 5100 (NPL)")
    channels = sets.sensitivities(camera)
    assert channels.shape == (61, 9)
    np.testing.assert_allclose(channels[:, :3], camera)
    np.testing.assert_allclose(channels[:, 4], camera[:, 1] * green_filter, rtol=1e-6)


def test_without_filters_nothing_changes():
    sets = filter_sets([ViewSettings(PHOTO, 0.0), ViewSettings(PHOTO, 120.0)])
    assert (sets.group, sets.partner) == ((0, 0), (0, 1))
    assert sets.transmittances.tolist() == [[1.0] * 61]


def test_a_filtered_view_alone_is_refused(curve, green_filter):
    views = [ViewSettings(PHOTO, 0.0), ViewSettings(PHOTO, 90.0, filter=curve("g.csv", green_filter))]
    with pytest.raises(SpectralProbeError, match=r"View 2 .* no view without a filter has its azimuth 90"):
        filter_sets(views)


@pytest.mark.parametrize(
    ("transmittance", "message"),
    [
        (np.full(61, 55.0), "in percent"),
        (np.linspace(-0.2, 0.5, 61), "fractions from 0 to 1"),
        (np.zeros(61), "lets no light through"),
        (np.full(61, 0.25), "is grey"),
    ],
)
def test_useless_filters_are_refused(curve, transmittance, message):
    views = [ViewSettings(PHOTO), ViewSettings(PHOTO, filter=curve("filter.csv", transmittance))]
    with pytest.raises(SpectralProbeError, match=message):
        filter_sets(views)


def test_glasses_are_filters_by_name():
    sets = filter_sets([ViewSettings(PHOTO), ViewSettings(PHOTO, filter="green")])
    assert sets.transmittances[1].argmax() == pytest.approx(26, abs=4)  # about 530 nm
    with pytest.raises(SpectralProbeError, match='There is no glass "grene"'):
        filter_sets([ViewSettings(PHOTO), ViewSettings(PHOTO, filter="grene")])
