import json

import numpy as np
import pytest

from spectral_probe.errors import SpectralProbeError
from spectral_probe.render.rgb_ways import (
    WAYS,
    compare_rgb_ways,
    metal_reflectances,
    way_colours,
    ways_report,
)
from spectral_probe.spectra.colorimetry import illuminant, spectra_to_xyz
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.library import lamp_spectrum

# Section 6 of the reference data's report: Johnson & Christy under D65, spectral x, y; then x, y and dE2000 by A0, A and B, and
# dE2000 by D. The last two metals are other publications of n and k, of which it has dE2000 alone.
SECTION_6 = {
    "gold": ((0.3820, 0.3895), (0.3594, 0.3786, 5.3), (0.3805, 0.3917, 1.2), (0.3663, 0.3794, 3.7), 1.4),
    "silver": ((0.3134, 0.3300), (0.2927, 0.3105, 9.3), (0.3133, 0.3299, 0.05), (0.3132, 0.3298, 0.14), 0.04),
    "copper": ((0.3560, 0.3453), (0.3338, 0.3271, 7.5), (0.3563, 0.3443, 0.6), (0.3434, 0.3380, 3.7), 0.9),
}
OTHER_FILMS = {
    "main/Au/Olmon-ev": ((0.3841, 0.4007), (5.8, 1.8, 3.5, 1.3)),
    "main/Cu/McPeak": ((0.3589, 0.3480), (8.6, 3.2, 4.9, 1.2)),
}


def under(light, *metals):
    return compare_rgb_ways(metal_reflectances(metals), lamp_spectrum(light), light).surfaces


@pytest.mark.parametrize("metal", SECTION_6)
def test_d65_row_of_section_6(metal):
    (colours,) = under("D65", metal)
    spectral, *sampled, delta_e_d = SECTION_6[metal]
    assert colours.xy_spectral == pytest.approx(spectral, abs=5e-5)  # it has four decimals
    for way, (x, y, delta_e) in zip(("A0", "A", "B"), sampled, strict=True):
        assert colours.way(way).xy == pytest.approx((x, y), abs=1.01e-4)
        assert colours.way(way).delta_e == pytest.approx(delta_e, abs=0.06)  # printed of 5.25: 5.3
        assert colours.way(way).xy_shift == pytest.approx(np.subtract((x, y), spectral), abs=1.5e-4)
    assert colours.way("D").delta_e == pytest.approx(delta_e_d, abs=0.05)


@pytest.mark.parametrize("metal", OTHER_FILMS)
def test_other_publications_of_section_6(metal):
    (colours,) = under("D65", metal)
    spectral, differences = OTHER_FILMS[metal]
    assert colours.xy_spectral == pytest.approx(spectral, abs=5e-5)
    assert [way.delta_e for way in colours.ways] == pytest.approx(differences, abs=0.051)


@pytest.mark.parametrize("light", ["D65", "A", "FL11", "HP1"])
def test_white_is_kept_by_all_ways_but_a0(light):
    white = compare_rgb_ways({"white": np.ones(61)}, lamp_spectrum(light), light)
    (colours,) = white.surfaces
    assert colours.xyz_spectral == pytest.approx(white.white_xyz)
    for way in colours.ways:
        if way.way == "A0":
            assert way.xyz[1] == pytest.approx(1.0)
            assert max(map(abs, way.xy_shift)) > 0.005
        else:
            assert way.xyz == pytest.approx(white.white_xyz)
            assert way.delta_e == pytest.approx(0, abs=1e-6)


def test_a0_is_white_at_the_point_of_section_6():
    (colours,) = compare_rgb_ways({"white": np.ones(61)}, illuminant("D65")).surfaces
    assert colours.way("A0").xy == pytest.approx((0.2921, 0.3099), abs=5e-5)


def test_a_surface_that_three_wavelengths_know_is_right_by_a():
    reflectance = np.full(61, 0.4)
    for way, xyz in way_colours(reflectance, illuminant("A")):
        if way != "A0":
            np.testing.assert_allclose(xyz, 0.4 * spectra_to_xyz(illuminant("A")))


def test_spiky_light_separates_the_ways_where_daylight_does_not():
    for metal in ("gold", "copper"):
        differences = {light: under(light, metal)[0].way("D").delta_e for light in ("D65", "HP1")}
        assert differences["HP1"] > 3 * differences["D65"]


def test_names_and_numbers_for_json():
    ways = compare_rgb_ways(metal_reflectances(["Au", "Silver", "main/Cu/McPeak"]), illuminant("A"), "A")
    told = json.loads(json.dumps(ways_report(ways), allow_nan=False))
    assert list(told["metals"]) == ["Gold", "Silver", "main/Cu/McPeak"]
    assert told["light"] == "A"
    assert told["ways"] == WAYS
    assert told["metals"]["Gold"]["B"]["delta_e"] == ways.surfaces[0].way("B").delta_e
    assert told["white_xy"] == pytest.approx((0.4476, 0.4074), abs=5e-4)


def test_a_line_between_the_wavelengths_leaves_a0_out():
    line = np.where(WAVELENGTHS_NM == 590.0, 1.0, 0.0)
    ways = compare_rgb_ways({"grey": np.full(61, 0.5)}, line, "a line")
    (grey,) = ways.surfaces
    assert [way.way for way in grey.ways] == ["A", "B", "D"]
    assert grey.way("A0") is None
    assert all(np.isfinite(way.delta_e) for way in grey.ways)
    assert len(ways.remarks) == 3
    assert ways.remarks[0].startswith("A0 is left out")


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: compare_rgb_ways({"grey": np.ones(61)}, np.zeros(61), "nothing"), '"nothing" is black'),
        (lambda: compare_rgb_ways({"grey": np.ones(61)}, np.full(61, np.nan), "x"), "not a number"),
        (lambda: metal_reflectances(["gould"]), 'Did you mean "Au"'),
        (lambda: metal_reflectances([]), "at least one metal"),
    ],
)
def test_bad_input_is_one_clear_line(call, message):
    with pytest.raises(SpectralProbeError, match=message) as caught:
        call()
    assert "\n" not in str(caught.value)
