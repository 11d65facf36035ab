"""The one family of errors whose text is meant for the person at the keyboard.

Every message says what is wrong and what to do about it, in one line. The command line prints it and
exits with 2; a Blender operator reports it. Any other exception is a defect and propagates.
"""

from __future__ import annotations


class SpectralProbeError(Exception):
    """Something the user can put right; the message says how."""


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
