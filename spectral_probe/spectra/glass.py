"""Stained glasses: spectral transmittances of the panes that come with the program, and of a user's own files."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ..errors import SpectralDataError
from ..files.spectrum_csv import read_spectrum_csv
from ..model import FloatArray

_FOLDER = Path(__file__).resolve().parents[1] / "data" / "glass"

_PANES = {
    "copper-ruby": _FOLDER / "red_copper_ruby.csv",
    "gold-ruby": _FOLDER / "red_gold_ruby.csv",
    "selenium-red": _FOLDER / "red_selenium_param.csv",
    "cadmium-orange": _FOLDER / "orange_cadmium_param.csv",
    "cadmium-yellow": _FOLDER / "yellow_cadmium_param.csv",
    "silver-stain": _FOLDER / "yellow_silver_stain.csv",
    "chromium-green": _FOLDER / "green_chromium_param.csv",
    "iron-green": _FOLDER / "green_iron_glass_silver_stained.csv",
}

SHORT_NAMES: Mapping[str, str] = {
    "red": "copper-ruby",
    "orange": "cadmium-orange",
    "yellow": "silver-stain",
    "green": "chromium-green",
}
"""Colours, and the pane each stands for. Red and yellow are the classical ones of church windows: ruby glass coloured by
copper, and silver stain. Of the two greens the chromium one lets enough light through (luminous transmittance 0.46 in
daylight against 0.17) to be seen beside them."""

GLASSES: Mapping[str, Path] = {
    **{short: _PANES[name] for short, name in SHORT_NAMES.items()},
    **_PANES,
}
"""Every glass that comes with the program by name, and its file; the short names first."""

_DARK_NOISE = 0.005
"""Transmittances this little below zero are a spectrophotometer's noise in the dark, and taken as zero."""

_LOOKS_LIKE_PERCENT = 2.0
"""Fractions above this were meant as percent: no error of measurement makes a pane pass twice the light."""


def glass_transmittance(name_or_path: str | Path) -> FloatArray:
    """Spectral transmittance of a glass by name, or of a user's file.

    Parameters
    ----------
    name_or_path
        One of `GLASSES` (capitals, spaces and underscores do not matter), or the path of a table of wavelength in nm and
        transmittance as a fraction.

    Returns
    -------
    ndarray
        (61,) in 0..1, on `grid.WAVELENGTHS_NM`.

    Raises
    ------
    SpectralDataError
        If there is no glass of that name and no such file, or if the file does not hold transmittances as fractions.

    Examples
    --------
    >>> red = glass_transmittance("red")
    >>> red.shape, bool(red[50] > 10 * red[20])  # 650 nm against 500 nm
    ((61,), True)
    """
    text = str(name_or_path)
    known = GLASSES.get("-".join(text.lower().replace("_", " ").split()))
    path = Path(text).expanduser()
    if known is None and not path.is_file():
        raise SpectralDataError(_unknown(text))
    return _checked(read_spectrum_csv(known or path)[0], (known or path).name)


def _unknown(text: str) -> str:
    if Path(text).suffix or Path(text).name != text:
        return f"There is no file {text}. Check the path, or name a glass: {', '.join(GLASSES)}."
    wanted = text.lower()
    near = [name for name in GLASSES if wanted in name] or difflib.get_close_matches(
        wanted, GLASSES, n=1, cutoff=0.4
    )
    hint = f'Did you mean "{near[0]}"? ' if near else ""
    return f'There is no glass "{text}". {hint}Known are {", ".join(GLASSES)}; or give a CSV file.'


def _checked(transmittance: FloatArray, name: str) -> FloatArray:
    highest, lowest = float(transmittance.max()), float(transmittance.min())
    if highest > _LOOKS_LIKE_PERCENT:
        raise SpectralDataError(
            f"The transmittance in {name} reaches {highest:g}, so it is in percent. Divide it by 100."
        )
    if highest > 1.0:
        raise SpectralDataError(
            f"The transmittance in {name} reaches {highest:g}; no glass passes more light than it gets. "
            "Give fractions from 0 to 1."
        )
    if lowest < -_DARK_NOISE:
        raise SpectralDataError(
            f"The transmittance in {name} falls to {lowest:g}. Give fractions from 0 to 1."
        )
    return np.maximum(transmittance, 0.0)
