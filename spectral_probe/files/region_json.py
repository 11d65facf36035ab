"""Region files: `{"polygon_deg": [[az, el], ...]}`, `{"mask": "m.png"}` or `{"seed_deg": [az, el]}`, in JSON."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from ..errors import FileFormatError, SpectralDataError
from ..model import Region
from ..spectra.regions import check_region
from .json_object import MOST_BYTES
from .toml import is_number

_EXAMPLES = '{"polygon_deg": [[az, el], ...]}, {"mask": "m.png"} or {"seed_deg": [az, el]}'


def read_region(path: Path) -> Region:
    """Read the region of a panorama from a JSON file.

    Parameters
    ----------
    path
        The file: an object with one of the three keys. A mask's path is relative to it.

    Returns
    -------
    Region

    Raises
    ------
    FileFormatError
        If the file is missing, is no JSON, or describes no region; the message names the file.
    """
    path = Path(path)
    if not path.is_file():
        raise FileFormatError(f"There is no region file {path}. Check the path.")
    try:
        if path.stat().st_size > MOST_BYTES:
            raise ValueError("too large")
        data = json.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError, RecursionError):
        raise FileFormatError(f"{path.name} is not valid JSON. Write {_EXAMPLES}.") from None
    try:
        region = region_from(data, path.parent)
        check_region(region)
    except SpectralDataError as problem:
        raise FileFormatError(f"{path.name}: {problem}") from None
    return region


def region_from(data: Any, folder: Path) -> Region:
    """The region that parsed JSON describes; masks are looked for in `folder`.

    Raises
    ------
    SpectralDataError
        If it describes none.

    Examples
    --------
    >>> region_from({"seed_deg": [30, 12.5]}, Path())
    Region(polygon_deg=None, mask=None, seed_deg=(30.0, 12.5))
    """
    if not isinstance(data, dict) or len(data) != 1:
        raise SpectralDataError(f"A region is one of {_EXAMPLES}, and nothing else.")
    ((key, value),) = data.items()
    if key == "polygon_deg" and isinstance(value, list):
        return Region(polygon_deg=tuple(_bearing(corner) for corner in value))
    if key == "mask" and isinstance(value, str) and value:
        return Region(mask=folder / value)
    if key == "seed_deg":
        return Region(seed_deg=_bearing(value))
    raise SpectralDataError(f'"{key}" is not as it should be. A region is one of {_EXAMPLES}.')


def _bearing(value: Any) -> tuple[float, float]:
    numbers = isinstance(value, list) and all(is_number(number) for number in value)
    if not numbers or len(value) != 2:
        raise SpectralDataError(
            f"{json.dumps(value)} is no bearing: give two numbers, bearing and elevation in degrees."
        )
    return float(value[0]), float(value[1])
