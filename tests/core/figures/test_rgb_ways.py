import numpy as np
import pytest

from spectral_probe.figures.rgb_ways import MARKS, rgb_ways_figure, ways_rows
from spectral_probe.render.rgb_ways import WAYS, compare_rgb_ways, metal_reflectances
from spectral_probe.spectra.colorimetry import illuminant
from spectral_probe.spectra.grid import WAVELENGTHS_NM


@pytest.fixture(scope="module")
def ways():
    return compare_rgb_ways(metal_reflectances(["gold", "silver", "copper"]), illuminant("FL11"), "FL11")


def test_every_point_is_where_the_numbers_say(ways):
    figure = rgb_ways_figure(ways)
    axes = figure.axes[0]
    drawn = {
        (line.get_marker(), float(line.get_xdata()[0]), float(line.get_ydata()[0]))
        for line in axes.lines
        if len(line.get_xdata()) == 1
    }
    for surface in ways.surfaces:
        assert ("o", *surface.xy_spectral) in drawn
        for way in surface.ways:
            assert (MARKS[way.way][0], *way.xy) in drawn
    words = {text.get_text() for text in axes.texts}
    assert {"Gold", "Silver", "Copper", "white", "D65"} <= words
    assert {"spectral", *WAYS} == {text.get_text() for text in axes.get_legend().get_texts()}


def test_the_table_has_the_numbers(ways):
    cells = {text.get_text() for axes in rgb_ways_figure(ways).axes for text in axes.texts}
    gold = ways.surfaces[0]
    assert f"{gold.way('B').delta_e:.2f}" in cells
    assert f"{gold.way('A').xy[0]:.4f}, {gold.way('A').xy[1]:.4f}" in cells


def test_a_way_that_is_not_defined_is_a_dash():
    line = np.where(WAVELENGTHS_NM == 590.0, 1.0, 0.0)
    ways = compare_rgb_ways({"grey": np.full(61, 0.5)}, line, "a line")
    assert ways_rows(ways)[0][:2] == ("grey", "–")
    words = {text.get_text() for text in rgb_ways_figure(ways).texts}
    assert any(word.startswith("A0 is left out") for word in words)
