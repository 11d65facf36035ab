import ast

import matplotlib as mpl
import numpy as np
import pytest

from spectral_probe.errors import SpectralDataError
from spectral_probe.figures.curves import basis_figure, sensitivities_figure, subscript
from spectral_probe.figures.numbers import spectrum_numbers
from spectral_probe.figures.spectrum import spectrum_figure, wavelength_colours
from spectral_probe.spectra.colorimetry import illuminant
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.library import planck


def lines(axes):
    return {line.get_label(): line.get_ydata() for line in axes.lines}


def texts(figure):
    return " ".join(text.get_text() for text in figure.texts)


def test_estimate_and_measurement_share_the_measured_peak():
    measured = planck(2856.0)
    figure = spectrum_figure(WAVELENGTHS_NM, 40 * measured, measured, title="Lamp")
    drawn = lines(figure.axes[0])
    np.testing.assert_allclose(drawn["measured"].max(), 1)
    np.testing.assert_allclose(drawn["estimated"], drawn["measured"])
    assert "Lamp" in texts(figure)
    assert "GFC\N{NO-BREAK SPACE} 1.0000" in texts(figure)
    assert figure.axes[0].get_xlim() == (400, 700)


def test_numbers_given_replace_the_computed_ones():
    figure = spectrum_figure(WAVELENGTHS_NM, planck(3000.0), title="Lamp", numbers=[{"confidence": "0.9"}])
    assert "confidence\N{NO-BREAK SPACE} 0.9" in texts(figure)
    assert "CCT" not in texts(figure)


def test_band_is_scaled_with_the_estimate():
    estimated = planck(3000.0) * 5
    band = np.stack([0.9 * estimated, 1.2 * estimated])
    figure = spectrum_figure(WAVELENGTHS_NM, estimated, band=band, band_label="95 % band")
    axes = figure.axes[0]
    (filled,) = axes.collections
    assert filled.get_label() == "95 % band"
    heights = filled.get_paths()[0].vertices[:, 1]
    assert heights.max() == pytest.approx(1.2)
    assert axes.get_ylim()[1] > 1.2
    assert lines(axes)["estimated"].max() == pytest.approx(1.0)


def test_negative_spectra_are_not_cut_off():
    estimated = planck(3000.0) - 0.4
    axes = spectrum_figure(WAVELENGTHS_NM, estimated).axes[0]
    assert axes.get_ylim()[0] < lines(axes)["estimated"].min() < 0


def test_goodness_is_never_rounded_up_to_perfect():
    measured = planck(2856.0)
    wiggly = measured * (1 + 0.012 * np.sin(WAVELENGTHS_NM / 9))
    numbers = spectrum_numbers(WAVELENGTHS_NM, wiggly, measured)
    assert numbers["GFC"] == "0.9999"
    assert numbers["rel. RMSE"].startswith("0.9")
    kelvin = spectrum_numbers(WAVELENGTHS_NM, measured, measured, "true")["CCT"]
    assert kelvin.split("\N{THIN SPACE}")[0] == "2864"  # 8 K above, by the cut at 400 and 700 nm
    assert "(true 2864" in kelvin


def test_wavelengths_have_their_colours():
    (strip,) = wavelength_colours(400, 700).astype(int)
    assert strip.shape == (1200, 3)
    at = {nm: strip[round((nm - 400) * 4)] for nm in (450, 530, 650)}
    assert at[450].argmax() == 2
    assert at[530].argmax() == 1
    assert at[650].argmax() == 0


def test_a_band_far_above_the_curves_leaves_them_legible():
    estimated = planck(3000.0)
    huge = np.stack([0 * estimated, 40 * estimated])
    axes = spectrum_figure(WAVELENGTHS_NM, estimated, band=huge, band_label="95 % band").axes[0]
    assert 2 < axes.get_ylim()[1] < 2.5  # of curves up to 1: the band leaves the plot, and is seen to


def test_a_measurement_above_the_estimate_is_whole():
    tube, flat = illuminant("FL11"), np.ones(61)
    axes = spectrum_figure(WAVELENGTHS_NM, tube, flat).axes[0]
    assert axes.get_ylim()[1] > lines(axes)["estimated"].max() > 5
    assert lines(axes)["measured"].max() == 1


@pytest.mark.parametrize("light", [np.zeros(61), np.eye(61)[0], np.eye(61)[60]])
def test_black_and_narrow_light_is_drawn(light):
    for estimated, measured in ((light, None), (light, planck(3000.0)), (planck(3000.0), light)):
        band = np.stack([estimated, estimated])
        axes = spectrum_figure(WAVELENGTHS_NM, estimated, measured, band, title="Dark").axes[0]
        assert np.isfinite(axes.get_ylim()).all()


def fits(figure):
    """Whether all text lies within the figure."""
    width, height = figure.get_size_inches() * figure.dpi
    boxes = [text.get_window_extent() for text in figure.texts]
    return all(box.x0 >= 0 and box.y0 >= 0 and box.x1 <= width and box.y1 <= height for box in boxes)


def test_long_headings_are_broken_and_the_figure_grows():
    title = "The window at the far end of the gymnasium, third from the left, at noon in November, in fog, from below"
    long = spectrum_figure(WAVELENGTHS_NM, planck(3000.0), title=title)
    short = spectrum_figure(WAVELENGTHS_NM, planck(3000.0), title="Window")
    assert long.get_size_inches()[1] > short.get_size_inches()[1]
    assert fits(long)
    assert fits(basis_figure(WAVELENGTHS_NM, np.eye(61)[:12], title=title))
    assert " ".join(text.get_text() for text in long.texts).startswith(title)


def test_all_numbers_of_a_comparison_stand_in_the_heading():
    figure = spectrum_figure(WAVELENGTHS_NM, 3 * illuminant("FL2"), illuminant("FL11"), title="Tube")
    shown = texts(figure).replace("\N{NO-BREAK SPACE}", "").replace("\N{THIN SPACE}", "")
    for number in (
        "GFC 0.7228",
        "rel. RMSE 69.1%",
        "ΔE₀₀ light 2.1, ColorChecker 3.5, metals 5.0",
        "CCT 4224K (measured 4000K)",
        "Ra 64 (83)",
        "Rf 70 (80)",
        "Rg 86 (101)",
    ):
        assert number in shown
    assert fits(figure)


def test_likely_families_are_bars_and_the_rest_one():
    families = {"a": 0.1, "b": 0.6, "c": 0.05, "d": 0.15, "e": 0.06, "f": 0.04}
    figure = spectrum_figure(WAVELENGTHS_NM, planck(3000.0), families=families)
    bars = figure.axes[-1]
    assert [label.get_text() for label in bars.get_yticklabels()] == ["b", "d", "a", "e", "others"]
    widths = [bar.get_width() for bar in bars.patches[5:]]
    np.testing.assert_allclose(widths, [0.6, 0.15, 0.1, 0.06, 0.09])
    assert [text.get_text() for text in bars.texts] == ["60 %", "15 %", "10 %", "6 %", "9 %"]
    assert len(spectrum_figure(WAVELENGTHS_NM, planck(3000.0)).axes) == len(figure.axes) - 1


def test_basis_and_sensitivities_draw_every_curve():
    basis = np.linalg.svd(np.stack([planck(k) for k in (2000.0, 3000.0, 4000.0, 6000.0)]))[2][:3]
    drawn = lines(basis_figure(WAVELENGTHS_NM, basis).axes[0])
    for name, row in zip(("E₁", "E₂", "E₃"), basis, strict=True):
        np.testing.assert_array_equal(drawn[name], row)
    sensitivities = np.abs(basis.T) * 7
    drawn = lines(sensitivities_figure(WAVELENGTHS_NM, sensitivities).axes[0])
    np.testing.assert_allclose(
        np.stack([drawn[name] for name in "RGB"], -1), sensitivities / sensitivities.max()
    )


@pytest.mark.parametrize("count", [1, 4, 5, 7, 12])
def test_many_basis_functions_are_three_to_a_panel_with_one_scale(count):
    basis = np.random.default_rng(count).normal(size=(count, 61))
    panels = [axes for axes in basis_figure(WAVELENGTHS_NM, basis).axes if axes.lines]
    assert len(panels) == (1 if count <= 4 else -(-count // 3))
    assert len({axes.get_ylim() for axes in panels}) == 1
    drawn = {name: curve for axes in panels for name, curve in lines(axes).items() if name.startswith("E")}
    assert len(drawn) == count
    np.testing.assert_array_equal(drawn["E" + subscript(count)], basis[-1])


def test_channels_through_filters_are_told_apart():
    plain = np.random.default_rng(1).uniform(size=(61, 3))
    curves = np.hstack([plain, 0.5 * plain, 0.25 * plain])
    figure = sensitivities_figure(WAVELENGTHS_NM, curves, shots=["no filter", "Wratten 58", "Wratten 25"])
    drawn = figure.axes[0].lines
    assert [line.get_label() for line in drawn[::4]] == ["R  no filter", "G  Wratten 58", "B  Wratten 25"]
    assert len({(line.get_color(), str(line.get_linestyle()), line.is_dashed()) for line in drawn}) >= 6
    strokes = {
        line.get_label(): line._unscaled_dash_pattern for line in drawn
    }  # the public name rounds to "--"
    assert strokes["R  Wratten 58"] != strokes["R  Wratten 25"]
    np.testing.assert_allclose(drawn[6].get_ydata(), 0.25 * drawn[0].get_ydata())
    assert fits(figure)
    legend = figure.axes[0].get_legend().get_window_extent()
    assert legend.x1 <= figure.get_size_inches()[0] * figure.dpi
    with pytest.raises(SpectralDataError, match="3, 6 or 9 channels, not 4"):
        sensitivities_figure(WAVELENGTHS_NM, np.ones((61, 4)))


def test_figures_leave_no_state_behind():
    def settings():  # to ask for the backend would choose one
        return {name: mpl.rcParams[name] for name in mpl.rcParams if not name.startswith("backend")}

    before = settings()
    spectrum_figure(WAVELENGTHS_NM, planck(3000.0))
    assert settings() == before


def test_figures_do_without_pyplot(project_root):
    sources = list((project_root / "spectral_probe" / "figures").glob("*.py"))
    assert sources
    imported = {
        name
        for source in sources
        for node in ast.walk(ast.parse(source.read_text()))
        if isinstance(node, ast.Import | ast.ImportFrom)
        for name in [getattr(node, "module", None), *(alias.name for alias in node.names)]
    }
    assert not {"matplotlib.pyplot", "pyplot", "pylab"} & imported
