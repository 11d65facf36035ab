"""Spectral sensitivities of cameras: by name from colour-science, from a file of the user's, or from a folder of such files.

Files are CSV (`wavelength_nm,r,g,b`) or AMPAS JSON as in the Academy's rawtoaces-data collection.
"""

from __future__ import annotations

import difflib
import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..errors import SpectralDataError
from ..files.spectrum_file import is_spectrum_file, read_samples
from ..model import FloatArray
from .colorimetry import colour_matching_functions, xyz_to_rec709
from .colour_science import colour
from .curves import SENSITIVITY, SampledCurves, on_grid

REC709 = "Rec.709"
"""The "camera" of display-referred pictures and of HDR and EXR files: linear Rec.709, D65 white."""

_MOST_ALIKE = 1e4
"""Condition number of three curves beyond which they are as good as two: no camera comes near."""

_SAME_PEAK = 5e-3
"""Peaks of three channels that agree within this are a table's doing, not a sensor's; bands of 5 nm blunt them that much."""

_CANON_5D_II = "Canon EOS 5D Mark II"


def camera_names() -> tuple[str, ...]:
    """Names of the cameras whose sensitivities we carry.

    Examples
    --------
    >>> camera_names()
    ('Nikon 5100 (NPL)', 'Sigma SDMerill (NPL)', 'Canon EOS 5D Mark II', 'Rec.709')
    """
    return (*colour.MSDS_CAMERA_SENSITIVITIES, _CANON_5D_II, REC709)


def camera_sensitivities(model: str | None = None, file: Path | None = None) -> FloatArray:
    """Spectral sensitivities R_k(lambda) of a camera's channels, relative, on the exchange grid.

    Parameters
    ----------
    model
        A name of `camera_names`; `file` goes before it, and without either the pictures are taken as linear Rec.709.
    file
        CSV or AMPAS JSON; or a folder of them, of which `model` names one (`cameras_in`).

    Returns
    -------
    ndarray
        (61, 3) for R, G, B.

    Raises
    ------
    SpectralDataError
        If the name is unknown (the message suggests the nearest), or the file is missing, not of this kind, or cannot be
        the curves of a camera.

    Examples
    --------
    >>> from .grid import WAVELENGTHS_NM
    >>> int(WAVELENGTHS_NM[camera_sensitivities("Nikon 5100 (NPL)")[:, 2].argmax()])
    460
    """
    if file is not None:
        return _of_curves(_red_green_blue(read_samples(camera_file(Path(file), model))))
    if model is None or model == REC709:
        return xyz_to_rec709(colour_matching_functions())
    return _of_curves(camera_curves(model))


def camera_curves(model: str) -> SampledCurves:
    """The curves of a camera of the library as they were published; Rec.709 is computed and has none.

    Raises
    ------
    SpectralDataError
        If there is no camera of that name; the message suggests the nearest.
    """
    if model == _CANON_5D_II:
        folder = Path(colour.__file__).parent / "characterisation" / "datasets" / "rawtoaces"
        return read_samples(folder / "CANON_EOS_5DMark_II_RGB_Sensitivities.csv")
    if model in colour.MSDS_CAMERA_SENSITIVITIES:
        known = colour.MSDS_CAMERA_SENSITIVITIES[model]
        values = np.asarray(known.values, float).T
        return SampledCurves(model, np.asarray(known.wavelengths, float), values, ("R", "G", "B"))
    hint = _nearest(model, camera_names())
    raise SpectralDataError(
        f'There is no camera called "{model}" in the library. {hint}Known are {", ".join(camera_names())}; '
        'or give a file of your camera: sensitivities = "camera.csv".'
    )


def cameras_in(folder: Path) -> dict[str, Path]:
    """Files of sensitivities in a folder, by name of their camera (`camera_name`).

    Files that do not have three channels are passed over; whether those are good is seen when one is chosen.
    """
    found = {}
    for path in sorted(Path(folder).iterdir(), key=lambda path: path.name.casefold()):
        if not path.is_file() or not is_spectrum_file(path.name):
            continue
        try:
            samples = read_samples(path)
        except SpectralDataError:
            continue
        if has_three_channels(samples):
            found[camera_name(samples, path)] = path
    return found


def has_three_channels(samples: SampledCurves) -> bool:
    """Whether a table is one of R, G and B: by the names of its columns, or three that have none.

    Examples
    --------
    >>> nm, values = np.array([400.0, 700.0]), np.ones((3, 2))
    >>> has_three_channels(SampledCurves("a", nm, values, ("r", "g", "b")))
    True
    >>> has_three_channels(SampledCurves("a", nm, values, ("radiance", "standard_error", "measured")))
    False
    """
    names = [column.strip().casefold() for column in samples.columns]
    initials = [name[:1] for name in names]
    return (
        {"r", "g", "b"} <= set(names)
        or initials == ["r", "g", "b"]
        or names == ["value 1", "value 2", "value 3"]
    )


def camera_name(samples: SampledCurves, path: Path) -> str:
    """What a file's camera is called: as an AMPAS JSON says, else the file's name with blanks for underscores."""
    return samples.title or re.sub(r"_\d{3}_\d{3,4}_\d+$", "", path.stem).replace("_", " ")


def camera_file(path: Path, model: str | None) -> Path:
    """The file of sensitivities meant by a path: itself, or the one in the folder that belongs to a camera.

    Raises
    ------
    SpectralDataError
        If it is a folder and no camera is named, or it has none of that name; the message suggests the nearest.
    """
    if not path.is_dir():
        return path
    known = cameras_in(path)
    if not known:
        raise SpectralDataError(f"{path} has no file of camera sensitivities. Give CSV or AMPAS JSON files.")
    if model is None:
        some = ", ".join(list(known)[:8])
        raise SpectralDataError(f'{path} holds {len(known)} cameras. Say which: model = "..." of {some}.')
    by_letters = {_letters(name): file for name, file in known.items()} | {
        _letters(file.stem): file for file in known.values()
    }
    if _letters(model) not in by_letters:
        raise SpectralDataError(
            f'There is no camera called "{model}" in {path}. {_nearest(model, tuple(known))}'
            "List them with: library list camera --folder DIR."
        )
    return by_letters[_letters(model)]


def gains_lost(sensitivities: FloatArray) -> bool:
    """Whether curves (61, 3) were normalised channel by channel, so that the balance of the channels is lost.

    Examples
    --------
    >>> gains_lost(camera_sensitivities("Nikon 5100 (NPL)")), gains_lost(camera_sensitivities("Canon EOS 5D Mark II"))
    (True, False)
    """
    peaks = np.asarray(sensitivities, float).max(0)
    return bool(np.ptp(peaks) <= _SAME_PEAK * peaks.max())


def gains_remark(name: str, sensitivities: FloatArray) -> str | None:
    """A sentence for the user whose curves lost their gains; None where they did not."""
    if not gains_lost(sensitivities):
        return None
    return (
        f"The sensitivities of {name} are normalised channel by channel, so the gains of its channels are lost "
        "and all colours may be tinted. Calibrate them on one known light: a grey card or a lamp of known spectrum."
    )


def _of_curves(curves: SampledCurves) -> FloatArray:
    """Curves of three channels on the grid, (61, 3), after looking whether they can tell three colours apart."""
    sensitivities = on_grid(curves, SENSITIVITY).T
    if np.linalg.cond(sensitivities / sensitivities.max(0)) > _MOST_ALIKE:
        raise SpectralDataError(
            f"{curves.name} has channels that are alike, so it cannot tell colours apart (a singular system). "
            "Check its columns r, g, b."
        )
    return sensitivities


def _red_green_blue(samples: SampledCurves) -> SampledCurves:
    """The channels R, G, B by their names, or else the three columns there are."""
    named = [column.strip().upper() for column in samples.columns]
    order = [0, 1, 2] if len(named) == 3 else []
    for wanted in (("R", "G", "B"), ("RED", "GREEN", "BLUE")):
        if all(channel in named for channel in wanted):
            order = [named.index(channel) for channel in wanted]
    if not order:
        raise SpectralDataError(
            f"{samples.name} is no table of sensitivities: it has {len(named)} column(s) of values, not R, G, B. "
            "Its columns must be wavelength_nm,r,g,b."
        )
    columns = tuple(samples.columns[at] for at in order)
    return replace(samples, values=samples.values[order], columns=columns)


def _letters(name: str) -> str:
    return re.sub(r"[^a-z0-9]", "", name.casefold())


def _nearest(name: str, known: tuple[str, ...]) -> str:
    by_lower = {each.lower(): each for each in known}
    near = difflib.get_close_matches(name.lower(), by_lower, n=1, cutoff=0.3)
    return f'Did you mean "{by_lower[near[0]]}"? ' if near else ""
