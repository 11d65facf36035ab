"""How much memory a capture takes, and how much there is.

The need was measured (peak of the process, Linux, version 0.1): the libraries and tables alone 325 MiB, and 430 MiB with those
of a distribution's Blender; photographs of 24 megapixels, one of 8 bits 448 MiB more, three 1,048 MiB, three of 16 bits
1,238 MiB, and a second view of three 146 MiB more; panoramas of three views and 1024 texels width 165 MiB more, 2048 texels
977 MiB. What the formula adds to the first lies above each of the others, by 2 to 50 percent.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from .errors import SpectralProbeError
from .geometry.panorama import WIDTHS
from .model import Capture
from .photo.metadata import size_px

BASE_BYTES = 470_000_000
_PHOTO_BYTES = 16
"""For a pixel of each photograph of the view that is being measured."""

_VIEW_BYTES = 8
"""For a pixel of each view, which is kept until the panorama is put together."""

_TEXEL_BYTES, _TEXEL_VIEW_BYTES = 200, 100
"""For a texel of the panorama, and for each view in it."""

_UNKNOWN_PX = 24_000_000
_SHARE = 0.85
"""Of the memory that is free, what a batch takes."""


def memory_needed(capture: Capture, width_px: int | None) -> int:
    """Bytes that building a capture's probe takes at most, about.

    Parameters
    ----------
    capture
        The capture, whose photographs' headers are read.
    width_px
        Width of the panorama; None for the width that photographs filled by the ball would give.
    """
    views = [[_size(photo) for photo in view.photos] for view in capture.views]
    photographs = max(sum(width * height for width, height in sizes) for sizes in views)
    kept = sum(width * height for (width, height), *_ in views)
    if width_px is None:
        shortest = max(min(size) for sizes in views for size in sizes)
        width_px = min(max(round(math.pi / 2 * shortest), WIDTHS[0]), WIDTHS[1])
    texels = width_px**2 // 2
    return (
        BASE_BYTES
        + _PHOTO_BYTES * photographs
        + _VIEW_BYTES * kept
        + texels * (_TEXEL_BYTES + _TEXEL_VIEW_BYTES * len(views))
    )


def memory_free() -> int:
    """Bytes that a batch may take: most of what is free on this machine, within the limit of its container."""
    import psutil

    free = psutil.virtual_memory().available
    limits = [free, *_container_free(Path("/sys/fs/cgroup"))]
    return int(min(limits) * _SHARE)


def peak_bytes() -> int:
    """The most memory that this process has had."""
    import psutil

    peak = getattr(psutil.Process().memory_info(), "peak_wset", None)
    if peak is not None:  # Windows
        return int(peak)
    import resource
    import sys

    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


def _container_free(folder: Path) -> Sequence[int]:
    """What a container's limit leaves; nothing where there is none."""
    try:
        limit = (folder / "memory.max").read_text(encoding="ascii").strip()
        return [] if limit == "max" else [int(limit) - int((folder / "memory.current").read_text("ascii"))]
    except (OSError, ValueError):
        return []


def _size(photo: Path) -> tuple[int, int]:
    """Width and height of a photograph; a large one's where its header does not say."""
    try:
        size = size_px(photo)
    except SpectralProbeError:  # building the probe says what is wrong with it
        size = None
    side = math.isqrt(_UNKNOWN_PX)
    return size or (side, side)
