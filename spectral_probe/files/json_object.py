"""Small JSON files that processes leave for one another: read without trust in what they hold.

Whoever reads one says with `text`, `whole` and the like what each entry must be; all of them raise `ValueError`, `TypeError` or
`KeyError` where it is something else.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

MOST_BYTES = 64 * 2**20
"""No file of this kind is larger; a larger one is not read into memory."""

UNREADABLE = (
    OSError,
    ValueError,
    KeyError,
    TypeError,
    IndexError,
    AttributeError,
    OverflowError,
    RecursionError,
)
"""What damaged, hostile or mistyped content raises while it is read."""


def read_object(path: Path) -> dict[str, Any]:
    """The JSON object in a file.

    Raises
    ------
    OSError, ValueError, RecursionError
        If there is none, or the file is larger than `MOST_BYTES`.
    """
    if not path.is_file():  # a pipe would be waited for
        raise ValueError(f"{path.name} is no file")
    with path.open("rb") as file:
        content = file.read(MOST_BYTES + 1)
    if len(content) > MOST_BYTES:
        raise ValueError(f"{path.name} is too large")
    return table(json.loads(content.decode("utf-8")))


def table(value: Any) -> dict[str, Any]:
    """The value, if it is an object."""
    if not isinstance(value, dict):
        raise TypeError("no object")
    return value


def text(value: Any) -> str:
    """The value, if it is a text."""
    if not isinstance(value, str):
        raise TypeError("no text")
    return value


def texts(value: Any) -> tuple[str, ...]:
    """The values of a list of texts."""
    if not isinstance(value, list):
        raise TypeError("no list")
    return tuple(text(one) for one in value)


def sentences(value: Any) -> tuple[str, ...]:
    r"""The values of a list of texts for people: each in one line, without anything that controls a terminal.

    Examples
    --------
    >>> sentences(["two\nlines"])
    ('two lines',)
    """
    return tuple("".join(c if c.isprintable() else " " for c in one) for one in texts(value))


def truth(value: Any) -> bool:
    """The value, if it is true or false."""
    if not isinstance(value, bool):
        raise TypeError("neither true nor false")
    return value


def whole(value: Any, least: int = 0, most: int = 2**53) -> int:
    """The value, if it is a whole number within bounds.

    Examples
    --------
    >>> whole(3)
    3
    >>> whole(True)
    Traceback (most recent call last):
    ...
    TypeError: no whole number
    """
    if not isinstance(value, int) or isinstance(value, bool):
        raise TypeError("no whole number")
    if not least <= value <= most:
        raise ValueError("out of range")
    return value


def number(value: Any, least: float = -math.inf) -> float:
    """The value, if it is a finite number, of at least so much."""
    if not isinstance(value, int | float) or isinstance(value, bool):
        raise TypeError("no number")
    if not math.isfinite(value) or value < least:
        raise ValueError("out of range")
    return float(value)


def numbers(value: Any, count: int) -> list[float]:
    """The values of a list of so many finite numbers."""
    if not isinstance(value, list) or len(value) != count:
        raise TypeError(f"not {count} numbers")
    return [number(one) for one in value]
