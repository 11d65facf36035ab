"""The one family of errors whose text is meant for the person at the keyboard.

Every message says what is wrong and what to do about it, in one line. The command line prints it and
exits with 2; a Blender operator reports it. Any other exception is a defect and propagates.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any


class SpectralProbeError(Exception):
    """Something the user can put right; the message says how."""

    def __str__(self) -> str:
        r"""The message in one line, without what would move a terminal's cursor: names in it may come from anybody's file.

        Examples
        --------
        >>> str(SpectralProbeError("There is no file a\nb\x1b[2J."))
        'There is no file a b [2J.'
        """
        return printable(super().__str__())


def printable(text: str) -> str:
    r"""A text without anything that is not printed: line ends, control characters, halves of characters.

    Examples
    --------
    >>> printable("a\tb\ud800c")
    'a b c'
    """
    return "".join(letter if letter.isprintable() else " " for letter in text)


class CaptureError(SpectralProbeError):
    """The capture file, or what it asks for, cannot be used."""


class PhotographError(SpectralProbeError):
    """A photograph cannot be read, has no exposure, or does not fit its bracket."""


class OutlineError(SpectralProbeError):
    """The ball's outline cannot be found, or the ball is not wholly in the frame."""


class SpectralDataError(SpectralProbeError):
    """A camera, light, metal or reflectance is unknown, or does not cover 400-700 nm."""


class FileFormatError(SpectralProbeError):
    """A probe, panorama or image file is not what it should be."""


class FolderBusyError(FileFormatError):
    """Another process writes to a folder."""


class RenderError(SpectralProbeError):
    """The scene cannot be rendered as asked."""


class PartlyFailedError(SpectralProbeError):
    """Some of many things could not be done, and the others were.

    Parameters
    ----------
    failures
        A line for each that could not.
    numbers
        What is told of all.
    """

    def __init__(self, failures: Sequence[str], numbers: Mapping[str, Any]) -> None:
        super().__init__(*failures)
        self.failures = tuple(printable(line) for line in failures)
        self.numbers = numbers

    def __str__(self) -> str:
        """A line for each failure."""
        return "\n".join(self.failures)
