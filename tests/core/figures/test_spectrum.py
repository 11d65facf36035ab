import ast

import matplotlib as mpl
import numpy as np
import pytest

from spectral_probe.figures.curves import basis_figure, sensitivities_figure
from spectral_probe.figures.numbers import spectrum_numbers
from spectral_probe.figures.spectrum import spectrum_figure, wavelength_colours
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
