import numpy as np
import pytest

from spectral_probe.errors import SpectralDataError
from spectral_probe.spectra.colorimetry import chromaticity, illuminant, spectra_to_xyz, white_xyz
from spectral_probe.spectra.glass import GLASSES, SHORT_NAMES, glass_transmittance
from spectral_probe.spectra.grid import WAVELENGTHS_NM

# Chromaticity and luminous transmittance under D65, computed independently of this code from the same models, 3 decimals.
UNDER_D65 = {
    "copper-ruby": (0.598, 0.326, 0.05),
    "gold-ruby": (0.467, 0.277, 0.16),
    "silver-stain": (0.420, 0.459, 0.62),
    "iron-green": (0.312, 0.497, 0.17),
    "selenium-red": (0.680, 0.319, 0.13),
    "cadmium-orange": (0.565, 0.434, 0.46),
    "cadmium-yellow": (0.433, 0.519, 0.85),
    "chromium-green": (0.275, 0.572, 0.46),
}


@pytest.mark.parametrize("name", UNDER_D65)
def test_colours_under_daylight(name):
    xyz = spectra_to_xyz(glass_transmittance(name) * illuminant("D65"))
    white = spectra_to_xyz(illuminant("D65"))
    assert [*chromaticity(xyz), xyz[1] / white[1]] == pytest.approx(UNDER_D65[name], abs=6e-3)


def test_the_eight_panes_and_their_short_names():
    assert len(set(GLASSES.values())) == 8
    assert set(UNDER_D65) | set(SHORT_NAMES) == set(GLASSES)
    for short, name in SHORT_NAMES.items():
        assert np.array_equal(glass_transmittance(short), glass_transmittance(name))
    assert {"red", "yellow", "green"} <= set(SHORT_NAMES)
    assert white_xyz()[1] == 1


def test_names_are_forgiving():
    assert np.array_equal(glass_transmittance("Silver Stain"), glass_transmittance("silver_stain"))


def write(path, values, wavelengths=WAVELENGTHS_NM):
    rows = [f"{nm:g},{value:g}" for nm, value in zip(wavelengths, values, strict=True)]
    path.write_text("wavelength_nm,transmittance\n" + "\n".join(rows))
    return path


def test_a_file_of_ones_own(tmp_path):
    values = np.linspace(0.1, 0.9, 61)
    assert glass_transmittance(write(tmp_path / "blue.csv", values)) == pytest.approx(values, abs=1e-5)
    assert glass_transmittance(str(tmp_path / "blue.csv")) == pytest.approx(values, abs=1e-5)


def test_noise_in_the_dark_is_zero(tmp_path):
    values = np.full(61, 0.5)
    values[:5] = -0.002
    assert glass_transmittance(write(tmp_path / "a.csv", values))[:5].tolist() == [0.0] * 5


@pytest.mark.parametrize(
    ("values", "line"),
    [
        (
            np.full(61, 85.0),
            r"The transmittance in a\.csv reaches 85, so it is in percent\. Divide it by 100\.",
        ),
        (np.full(61, 1.02), r"reaches 1\.02; no glass passes more light than it gets\."),
        (np.full(61, -0.1), r"falls to -0\.1\."),
        (np.full(61, np.nan), r"a\.csv"),
    ],
)
def test_what_is_no_transmittance(tmp_path, values, line):
    with pytest.raises(SpectralDataError, match=line) as caught:
        glass_transmittance(write(tmp_path / "a.csv", values))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("yelow", 'There is no glass "yelow". Did you mean "yellow"?'),
        ("ruby", 'There is no glass "ruby". Did you mean "copper-ruby"?'),
        ("qqqq", 'There is no glass "qqqq". Known are red, orange'),
        ("lost.csv", "There is no file lost.csv. Check the path, or name a glass: red"),
        ("panes/blue", "There is no file panes/blue."),
    ],
)
def test_unknown_glasses(name, line):
    with pytest.raises(SpectralDataError) as caught:
        glass_transmittance(name)
    assert str(caught.value).startswith(line)
