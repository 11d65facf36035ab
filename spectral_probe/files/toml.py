"""Typed values out of TOML tables, with error messages that name the place; and values written as TOML."""

from __future__ import annotations

import difflib
import sys
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from ..errors import CaptureError

type Table = Mapping[str, Any]


class TomlReader:
    """Typed values out of the tables of a file called `name`, whose paths are relative to `folder`."""

    def __init__(self, name: str, folder: Path) -> None:
        self.name = name
        self.folder = folder

    def fail(self, where: str, key: str, wanted: str) -> CaptureError:
        """The error for a value that is not what was wanted."""
        return CaptureError(f"{self.name}, {where}: {key} must be {wanted}.")

    def check_keys(self, table: Table, known: Collection[str], where: str) -> None:
        """Refuse a key that is not known, and suggest the nearest."""
        for key in table:
            if key not in known:
                near = difflib.get_close_matches(key, known, n=1)
                hint = f'Did you mean "{near[0]}"?' if near else f"Known are {', '.join(known)}."
                raise CaptureError(f'{self.name}, {where}: there is no key "{key}". {hint}')

    def table(self, document: Table, key: str, known: Collection[str]) -> Table:
        """A table of the document, empty where it is missing."""
        table = document.get(key, {})
        if not isinstance(table, Mapping):
            raise CaptureError(f"{self.name}: write [{key}] once, as a table.")
        self.check_keys(table, known, f"[{key}]")
        return table

    def number(self, table: Table, key: str, where: str, *, positive: bool = False) -> float | None:
        """A number, or None where it is missing."""
        value = table.get(key)
        if value is None:
            return None
        if not is_number(value) or (positive and value <= 0):
            raise self.fail(where, key, "a positive number" if positive else "a number")
        return float(value)

    def truth(self, table: Table, key: str, where: str, *, default: bool) -> bool:
        """True or false."""
        value = table.get(key, default)
        if not isinstance(value, bool):
            raise self.fail(where, key, "true or false")
        return value

    def text(self, table: Table, key: str, where: str) -> str | None:
        """Text, or None where it is missing."""
        value = table.get(key)
        if value is not None and not isinstance(value, str):
            raise self.fail(where, key, "text in quotes")
        return value

    def texts(self, table: Table, key: str, where: str, wanted: str) -> tuple[str, ...] | None:
        """One text or a list of them, which may not be empty; None where it is missing."""
        value = table.get(key)
        if value is None:
            return None
        value = [value] if isinstance(value, str) else value
        if not isinstance(value, list) or not value or not all(isinstance(item, str) for item in value):
            raise self.fail(where, key, wanted)
        return tuple(value)

    def file(self, table: Table, key: str, where: str, *, or_folder: bool = False) -> Path | None:
        """A file, or where allowed a folder, that exists; None where the key is missing."""
        value = self.text(table, key, where)
        return None if value is None else self.existing(value, where, or_folder=or_folder)

    def existing(self, value: str, where: str, *, or_folder: bool = False) -> Path:
        """The path of a file, or where allowed a folder, that must exist."""
        path = self.folder / value
        try:
            there = path.is_file() or (or_folder and path.is_dir())
        except OSError:  # a name too long to be one, a folder that may not be read
            there = False
        if not there:
            raise CaptureError(f"{self.name}, {where}: there is no file {path}. Check the name.")
        return path

    def numbers(
        self, table: Table, key: str, where: str, lengths: Collection[int], *, positive: bool = False
    ) -> tuple[float, ...] | None:
        """A list of so many numbers, or None where it is missing."""
        value = table.get(key)
        if value is None:
            return None
        if not _are_numbers(value) or len(value) not in lengths:
            raise self.fail(where, key, f"a list of {' or '.join(map(str, sorted(lengths)))} numbers")
        if positive and any(item <= 0 for item in value):
            raise self.fail(where, key, "a list of positive numbers")
        return tuple(float(item) for item in value)

    def pair(self, table: Table, key: str, where: str) -> tuple[float, float] | None:
        """Two numbers, or None where they are missing."""
        value = self.numbers(table, key, where, {2})
        return None if value is None else (value[0], value[1])

    def pairs(self, table: Table, key: str, where: str) -> tuple[tuple[float, float], ...] | None:
        """A list of pairs of numbers, or None where it is missing."""
        value = table.get(key)
        if value is None:
            return None
        if not isinstance(value, list) or not all(_are_numbers(item) and len(item) == 2 for item in value):
            raise self.fail(where, key, "a list of pairs of numbers such as [[10, 5], [40, 5], [25, 30]]")
        return tuple((float(first), float(second)) for first, second in value)


def is_number(value: object) -> bool:
    """Whether a value of a TOML or JSON file is a finite number."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= sys.float_info.max


def _are_numbers(value: object) -> bool:
    return isinstance(value, list) and all(is_number(item) for item in value)


def entries(**values: object) -> list[str]:
    """Lines of a TOML table; values that are None are left out.

    Examples
    --------
    >>> entries(name="a ball", radius_m=0.05, place=(1, 2), nothing=None)
    ['name = "a ball"', 'radius_m = 0.05', 'place = [1, 2]']
    """
    return [f"{key} = {_toml(value)}" for key, value in values.items() if value is not None]


def relative(path: Path | None, folder: Path) -> str | None:
    """A path as it is written in a file in `folder`: relative to it where that can be."""
    if path is None:
        return None
    path = Path(path).resolve()
    return path.relative_to(folder).as_posix() if path.is_relative_to(folder) else path.as_posix()


def _toml(value: object) -> str:
    match value:
        case bool():
            return "true" if value else "false"
        case float() | int():
            return repr(value)
        case tuple():
            return f"[{', '.join(map(_toml, value))}]"
        case Mapping():
            return f"{{ {', '.join(f'{_toml(str(key))} = {_toml(item)}' for key, item in value.items())} }}"
        case _:
            escaped = str(value).replace("\\", "\\\\").replace('"', '\\"')
            return f'"{escaped}"'
