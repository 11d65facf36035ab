import json

import numpy as np
import pytest

from spectral_probe.errors import SpectralProbeError
from spectral_probe.files.probe_exr import write_probe
from spectral_probe.geometry.frames import bearing_to_direction, panorama_directions
from spectral_probe.light_choice import chosen_light
from spectral_probe.model import SpectralPanorama
from spectral_probe.spectra.colorimetry import illuminant
from spectral_probe.spectra.grid import WAVELENGTHS_NM


@pytest.fixture
def probe_file(tmp_path):
    """Daylight above, filament light below, a tube at bearing 330, elevation 20; the lowest row was not seen."""
    weights = np.zeros((32, 64, 3), np.float32)
    weights[:16, :, 0] = weights[16:, :, 1] = 1
    tube = panorama_directions(32, 64) @ bearing_to_direction(330, 20) > np.cos(np.radians(12))
    weights[tube] = (0, 0, 1)
    valid = np.ones((32, 64), bool)
    valid[-1] = False
    weights[-1] = 1000
    panorama = SpectralPanorama(
        weights,
        np.stack([illuminant(name) for name in ("D65", "A", "FL11")])[None],
        np.zeros((32, 64), np.uint8),
        WAVELENGTHS_NM,
        valid,
        np.ones((32, 64), np.float32),
    )
    write_probe(tmp_path / "probe.exr", panorama)
    return tmp_path / "probe.exr"


def test_the_mean_light_of_a_probe_is_by_solid_angle(probe_file):
    light = chosen_light(str(probe_file))
    share = (1 - np.cos(np.radians(12))) / 2  # of the sphere is the tube
    expected = (0.5 - share) * illuminant("D65") + 0.5 * illuminant("A") + share * illuminant("FL11")
    assert light.name == "mean light of probe.exr"
    np.testing.assert_allclose(light.spectrum, expected, rtol=0.01)


def test_light_of_a_direction(probe_file):
    light = chosen_light(str(probe_file), at=(330.0, 20.0))
    assert light.name == "light from 330°, 20°"
    np.testing.assert_allclose(light.spectrum, illuminant("FL11"), rtol=1e-3)


def test_light_of_a_region(probe_file, tmp_path):
    region = tmp_path / "floor.json"
    region.write_text(json.dumps({"polygon_deg": [[0, -30], [120, -30], [240, -30]]}))
    light = chosen_light(str(probe_file), region_path=region)
    assert light.name == "light of the region floor"
    np.testing.assert_allclose(light.spectrum, illuminant("A"), rtol=1e-3)


def test_lamps_and_files_have_their_own_spectra(tmp_path):
    table = tmp_path / "mine.csv"
    table.write_text("wavelength_nm,power\n" + "\n".join(f"{nm:g},{2 * nm:g}" for nm in WAVELENGTHS_NM))
    mine = chosen_light(str(table))
    assert mine.name == "mine.csv"
    np.testing.assert_allclose(mine.spectrum, 2 * WAVELENGTHS_NM)
    lamp = chosen_light("FL11")
    np.testing.assert_allclose(
        lamp.spectrum / lamp.spectrum.max(), illuminant("FL11") / illuminant("FL11").max()
    )


def test_directions_are_a_probes(probe_file, tmp_path):
    with pytest.raises(SpectralProbeError, match='"A" has no directions'):
        chosen_light("A", at=(0.0, 0.0))
    with pytest.raises(SpectralProbeError, match="not both"):
        chosen_light(str(probe_file), at=(0.0, 0.0), region_path=tmp_path / "x.json")
    with pytest.raises(SpectralProbeError, match="No view saw"):
        chosen_light(str(probe_file), at=(0.0, -90.0))
