"""Spectral sensitivities of cameras: by name from colour-science, or from a file of the user's.

Files are CSV (`wavelength_nm,r,g,b`) or AMPAS JSON as in the Academy's rawtoaces-data collection.
"""

from __future__ import annotations

import csv
import difflib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import SpectralDataError
from ..model import FloatArray
from .colorimetry import colour_matching_functions, xyz_to_rec709
from .colour_science import colour
from .grid import WAVELENGTHS_NM, resample

REC709 = "Rec.709"
"""The "camera" of display-referred pictures and of HDR and EXR files: linear Rec.709, D65 white."""

_MOST_ALIKE = 1e4
"""Condition number of three curves beyond which they are as good as two: no camera comes near."""

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
        CSV or AMPAS JSON.

    Returns
    -------
    ndarray
        (61, 3) for R, G, B.

    Raises
    ------
    SpectralDataError
        If the name is unknown (the message suggests the nearest), or the file is missing, not of this kind, or does
        not cover 400-700 nm.

    Examples
    --------
    >>> int(WAVELENGTHS_NM[camera_sensitivities("Nikon 5100 (NPL)")[:, 2].argmax()])
    460
    """
    if file is not None:
        return _from_file(Path(file))
    if model is None or model == REC709:
        return xyz_to_rec709(colour_matching_functions())
    if model == _CANON_5D_II:
        folder = Path(colour.__file__).parent / "characterisation" / "datasets" / "rawtoaces"
        return _from_file(folder / "CANON_EOS_5DMark_II_RGB_Sensitivities.csv")
    known: Mapping[str, Any] = colour.MSDS_CAMERA_SENSITIVITIES
    if model in known:
        return _measured(known[model])
    near = difflib.get_close_matches(
        model.lower(), [name.lower() for name in camera_names()], n=1, cutoff=0.3
    )
    by_lower = {name.lower(): name for name in camera_names()}
    hint = f'Did you mean "{by_lower[near[0]]}"? ' if near else ""
    raise SpectralDataError(
        f'There is no camera called "{model}" in the library. {hint}Known are {", ".join(camera_names())}; '
        'or give a file of your camera: sensitivities = "camera.csv".'
    )


def _measured(sensitivities: Any) -> FloatArray:
    """Curves of colour-science on our grid; those that end short of 700 nm below 1 % of their peak go on as zero."""
    wavelengths = np.asarray(sensitivities.wavelengths, float)
    values = np.asarray(sensitivities.values, float)
    if wavelengths[-1] < WAVELENGTHS_NM[-1] and (values[-1] < 0.01 * values.max(0)).all():
        wavelengths = np.append(wavelengths, [wavelengths[-1] + 1e-3, WAVELENGTHS_NM[-1]])
        values = np.concatenate([values, np.zeros((2, values.shape[1]))])
    return resample(wavelengths, values.T, name=str(sensitivities.name)).T


def _from_file(path: Path) -> FloatArray:
    try:
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise SpectralDataError(
            f"There is no file of camera sensitivities at {path}. Check the path."
        ) from None
    except (OSError, UnicodeDecodeError) as problem:
        raise SpectralDataError(
            f"{path} cannot be read as text ({problem}). Give a CSV or an AMPAS JSON file."
        ) from None
    samples = _json_samples(text, path) if path.suffix.lower() == ".json" else _csv_samples(text, path)
    if samples.ndim != 2 or not np.isfinite(samples).all():
        raise SpectralDataError(
            f"{path.name} has no table of finite numbers. Its columns must be wavelength_nm,r,g,b."
        )
    if len(np.unique(samples[:, 0])) != len(samples):
        raise SpectralDataError(f"{path.name} lists a wavelength twice. Keep one line a wavelength.")
    sensitivities = resample(samples[:, 0], samples[:, 1:].T, name=path.name).T
    if (sensitivities.max(0) <= 0).any():
        raise SpectralDataError(
            f"{path.name} has a channel without any sensitivity. Check its columns r, g, b."
        )
    if np.linalg.cond(sensitivities / sensitivities.max(0)) > _MOST_ALIKE:
        raise SpectralDataError(f"{path.name} has channels that are alike. Check its columns r, g, b.")
    return sensitivities


def _csv_samples(text: str, path: Path) -> FloatArray:
    """(N, 4): wavelength in nm and three sensitivities."""
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    rows: list[list[float]] = []
    for number, row in enumerate(csv.reader(lines)):
        try:
            rows.append([float(cell) for cell in row[:4]])
        except ValueError:
            if number > 0:  # the first line may name the columns
                raise SpectralDataError(
                    f'{path.name} has a line that is not four numbers: "{lines[number].strip()[:60]}". '
                    "Its columns must be wavelength_nm,r,g,b."
                ) from None
    if not rows or any(len(row) != 4 for row in rows):
        raise SpectralDataError(
            f"{path.name} is no table of sensitivities. Its columns must be wavelength_nm,r,g,b."
        )
    return np.array(rows)


def _json_samples(text: str, path: Path) -> FloatArray:
    """(N, 4) from AMPAS JSON: {"spectral_data": {"index": {"main": [...]}, "data": {"main": {"380": [r, g, b], ...}}}}."""
    try:
        spectral = json.loads(text)["spectral_data"]
        order = [str(channel).upper() for channel in spectral["index"]["main"]]
        columns = [order.index(channel) for channel in "RGB"]
        table = spectral["data"]["main"]
        return np.array(
            [[float(nm), *(float(values[column]) for column in columns)] for nm, values in table.items()]
        )
    except (json.JSONDecodeError, KeyError, TypeError, ValueError, IndexError, AttributeError):
        raise SpectralDataError(
            f"{path.name} is not a camera file in AMPAS JSON (spectral_data with index and data of R, G, B)."
        ) from None
