"""Swatches: colours by which materials are told apart, adapted to the light."""

import numpy as np
import pytest

from spectral_probe.errors import SpectralDataError
from spectral_probe.figures.display import srgb_encoded
from spectral_probe.spectra.colorimetry import illuminant, spectra_to_xyz, white_xyz, xyz_to_rec709
from spectral_probe.spectra.library import lamp_spectrum
from spectral_probe.spectra.metals import metal_reflectance
from spectral_probe.spectra.swatches import (
    SURFACES,
    lamp_colours,
    library_swatches,
    matching,
    page_swatches,
    plate_transmittance,
    reflected_colours,
)


@pytest.fixture(scope="module")
def d65():
    return library_swatches(illuminant("D65"))


@pytest.mark.parametrize("light", ["D65", "A", "FL11", "HPS", "LED-RGB1", "Planck 2000 K"])
@pytest.mark.parametrize("grey", [0.05, 0.18, 1.0])
def test_grey_is_grey_and_white_is_white_under_every_light(light, grey):
    shown = reflected_colours(np.full(61, grey), lamp_spectrum(light))
    assert shown == pytest.approx(np.full(3, srgb_encoded(np.array(grey))), abs=2e-3)


def test_under_d65_it_is_the_colour_itself():
    gold = metal_reflectance("Ag", np.array(1.0))
    light = illuminant("D65")
    xyz = spectra_to_xyz(gold * light) / spectra_to_xyz(light)[1]
    expected = srgb_encoded(xyz_to_rec709(xyz))
    assert reflected_colours(gold, light) == pytest.approx(expected, abs=1e-6)
    assert spectra_to_xyz(light) / spectra_to_xyz(light)[1] == pytest.approx(white_xyz())


def test_light_of_one_line_tells_no_colours():
    line = np.zeros(61)
    line[38] = 1.0  # 590 nm
    shown = reflected_colours(np.stack([metal_reflectance("Au", np.array(1.0)), np.full(61, 0.3)]), line)
    assert np.ptp(shown, axis=-1).max() < 0.02
    assert shown[0].mean() > shown[1].mean()


def test_the_scale_of_the_light_does_not_matter_but_it_must_not_be_dark():
    curve, light = metal_reflectance("Cu", np.array(1.0)), illuminant("A")
    assert reflected_colours(curve, 1e-9 * light) == pytest.approx(reflected_colours(curve, light))
    with pytest.raises(SpectralDataError, match="Choose another light"):
        reflected_colours(curve, np.zeros(61))


def test_lamps_have_their_colour_at_full_brightness():
    warm, day, cold = lamp_colours(np.stack([lamp_spectrum(n) for n in ("A", "D65", "Daylight 20000 K")]))
    assert day == pytest.approx([1.0, 1.0, 1.0], abs=5e-3)
    assert warm[0] == pytest.approx(1.0)
    assert warm[0] > warm[1] > warm[2]
    assert cold[2] == pytest.approx(1.0)
    assert cold[2] > cold[1] > cold[0]


def test_the_library_is_listed_once_with_its_passport(d65):
    assert len({swatch.key for swatch in d65}) == len(d65)
    assert {swatch.kind for swatch in d65} == {*SURFACES, "LAMP"}
    assert all(swatch.source and swatch.licence and swatch.label for swatch in d65)
    assert all(0.0 <= channel <= 1.0 for swatch in d65 for channel in swatch.rgb)


def test_gold_is_yellow_copper_red_and_ruby_dark_red(d65):
    rgb = {swatch.key: swatch.rgb for swatch in d65}
    for name, order in (
        ("METAL|Au", "rgb"),
        ("METAL|Cu", "rgb"),
        ("GLASS|red", "rbg"),
        ("GLASS|green", "gbr"),
    ):
        by_channel = dict(zip("rgb", rgb[name], strict=True))
        assert sorted("rgb", key=by_channel.__getitem__, reverse=True) == list(order), name


def test_words_are_found_in_any_order_and_case(d65):
    assert [found.name for found in matching(d65, "JOHNSON gold") if found.kind == "METAL"] == ["Au"]
    assert matching(d65, "no such thing") == ()
    assert matching(d65, "  ") == d65


def test_pages_are_metals_or_clear():
    job, pages = page_swatches(illuminant("D65")), ()
    fractions = []
    while True:
        try:
            fractions.append(next(job).fraction)
        except StopIteration as stop:
            pages = stop.value
            break
    assert fractions == sorted(fractions)
    assert len(fractions) > 5
    kinds = {swatch.name: swatch.kind for swatch in pages}
    assert kinds["main/Au/Johnson"] == "METAL"
    assert kinds["popular_glass/BK7/SCHOTT"] == "DISPERSIVE"
    assert "METAL" not in {kind for name, kind in kinds.items() if name.startswith("popular_glass/")}
    assert next(found.label for found in matching(pages, "gold johnson")) == "Gold: Johnson"


def test_a_clear_plate_passes_all_but_its_reflections():
    assert plate_transmittance(np.array([1.0, 1.5, 2.42])) == pytest.approx([1.0, 0.923, 0.706], abs=1e-3)
