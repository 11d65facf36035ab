"""An asset that was appended renders spectrally as what it is."""

from pathlib import Path

import bpy
import numpy as np
import pytest

BLEND = Path(__file__).resolve().parents[2] / "assets" / "spectral_materials.blend"
NM = [450.0, 550.0, 650.0]
LIGHT = np.full(61, 0.01)


@pytest.mark.usefixtures("scene")
def test_appended_gold_reflects_as_gold_at_every_wavelength(radiance, ball, extension):
    ball()
    with bpy.data.libraries.load(str(BLEND), assets_only=True) as (source, target):
        target.materials = [name for name in source.materials if name == "Gold"]
    bpy.context.object.data.materials[0] = target.materials[0]
    images, warnings = radiance(NM, "light-basis", LIGHT)
    metals = extension("spectral_probe.spectra.metals")
    expected = 0.01 * metals.metal_reflectance("Au", np.array(1.0), np.array(NM))
    seen = images[:, 28:36, 28:36].mean((1, 2))
    np.testing.assert_allclose(seen, expected, rtol=0.02)  # roughness 0.1: a lobe of a few degrees
    assert warnings == []
