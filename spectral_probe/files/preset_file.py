"""Presets: some settings by name, as TOML. They are read as data; nothing in them is run."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path

from ..errors import FileFormatError
from .atomic import written_whole
from .toml import entries

type Setting = bool | int | float | str | list[Setting]

_MOST_BYTES = 1_000_000


def read_preset(path: Path) -> dict[str, Setting]:
    """The settings of a preset by their dotted names, such as `camera.model`.

    Raises
    ------
    FileFormatError
        If the file cannot be read, or is no TOML of plain values.
    """
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise FileFormatError(f"{path.name} is too large to be a preset. Remove it from the presets.")
        if not path.is_file() and path.exists():
            raise FileFormatError(f"{path.name} is no file. Remove it from the presets.")
        return _flat(tomllib.loads(path.read_text(encoding="utf-8")), path)
    except OSError as problem:
        raise FileFormatError(
            f"The preset {path} cannot be read ({problem.strerror}). Check its name and permissions."
        ) from problem
    except (
        ValueError,
        RecursionError,
    ) as problem:  # no TOML, no UTF-8, numbers of thousands of digits, deep lists
        raise FileFormatError(
            f"{path.name} is no preset ({problem}). Save it again, or remove it."
        ) from problem


def _flat(table: Mapping[str, object], path: Path, before: str = "") -> dict[str, Setting]:
    settings: dict[str, Setting] = {}
    for key, value in table.items():
        if isinstance(value, dict):
            settings |= _flat(value, path, f"{before}{key}.")
        elif isinstance(value, bool | int | float | str | list):
            settings[before + key] = value
        else:
            raise FileFormatError(
                f"{path.name}: {before}{key} is no plain value. Save the preset again, or remove it."
            )
    return settings


def write_preset(path: Path, settings: Mapping[str, Setting]) -> None:
    r"""Write settings by their dotted names, one table deep at most; the file is there whole or not at all.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "mine.toml"
    >>> write_preset(path, {"camera.model": "Nikon 5100 (NPL)", "ball_radius": 0.05})
    >>> path.read_text()
    'ball_radius = 0.05\n\n[camera]\nmodel = "Nikon 5100 (NPL)"\n'
    >>> read_preset(path)
    {'ball_radius': 0.05, 'camera.model': 'Nikon 5100 (NPL)'}
    """
    tables: dict[str, dict[str, Setting]] = {"": {}}
    for name, value in settings.items():
        table, _, key = name.rpartition(".")
        tables.setdefault(table, {})[key] = value
    parts = []
    for table, values in tables.items():
        lines = entries(
            **{key: tuple(value) if isinstance(value, list) else value for key, value in values.items()}
        )
        if table:
            lines.insert(0, f"[{table}]")
        if lines:
            parts.append("\n".join(lines) + "\n")
    with written_whole(path) as temporary:
        temporary.write_text("\n".join(parts), encoding="utf-8")
