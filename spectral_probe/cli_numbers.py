"""Numbers on the command line, for argparse: what is none gets one clear sentence."""

from __future__ import annotations

import argparse
import math


def whole_number(text: str) -> int:
    """A whole number above 0."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f'"{text}" is no whole number above 0')
    return int(text)


def positive_number(text: str) -> float:
    """A number above 0.

    Examples
    --------
    >>> positive_number("2.5")
    2.5
    """
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f'"{text}" is not a number above 0')
    return value
