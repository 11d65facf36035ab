"""OpenEXR images of named channels: reading, writing, and errors a user can act on."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR

from ..errors import FileFormatError
from ..model import FloatArray
from .atomic import destined, written_whole
from .exr_limits import check_exr, check_readable, refuse_deep
from .exr_rows import ExrRows, MakeRows, encode_rows
from .silence import libraries_silenced

type Header = dict[str, Any]


def write_channels(path: Path, channels: Mapping[str, Any], header: Mapping[str, Any] | None = None) -> None:
    """Write an OpenEXR image, whole or not at all.

    Parameters
    ----------
    path
        The file.
    channels
        (H, W) arrays by channel name; float32 and float16 are kept as they are.
    header
        Attributes: text or numbers.

    Raises
    ------
    FileFormatError
        If it cannot be written there, as on a full disk.
    """
    size = next((np.shape(channel) for channel in channels.values()), (0, 0))
    write_rows(
        path, (size[0], size[1]), lambda rows: {name: plane[rows] for name, plane in channels.items()}, header
    )


def write_rows(
    path: Path, size: tuple[int, int], make: MakeRows, header: Mapping[str, Any] | None = None
) -> None:
    """Write an OpenEXR image whose rows are made some at a time, whole or not at all: it may be larger than the memory.

    Parameters
    ----------
    path
        The file.
    size
        Height and width in pixels.
    make
        Gives the channels (h, W) of some rows by name, in threads and not always in order.
    header
        Attributes: text or numbers.

    Raises
    ------
    FileFormatError
        If it cannot be written there, as on a full disk.
    """
    attributes: Header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        **(header or {}),
    }
    with written_whole(path) as temporary:
        try:
            with temporary.open("wb") as file:
                encode_rows(file, size, make, attributes)
        except OSError as problem:
            free = shutil.disk_usage(temporary.parent).free / 1e6
            raise FileFormatError(
                f"{destined(path)} cannot be written ({problem.strerror or problem}); {free:.0f} MB are free there. "
                "Make room, or choose another place."
            ) from None


def read_channels(path: Path) -> tuple[dict[str, Any], Header]:
    """Channels (H, W) by name, and the header, of an OpenEXR image.

    Raises
    ------
    FileFormatError
        If the file is missing or is not OpenEXR.
    """
    path = Path(path)
    _check_there(path)
    check_readable(path)
    try:
        with libraries_silenced():
            file = OpenEXR.File(str(path), separate_channels=True)
            channels, header = file.channels(), file.header()
    except RuntimeError as problem:
        raise FileFormatError(
            f"{path.name} cannot be read as OpenEXR ({problem}). It may be cut short."
        ) from None
    except ValueError:  # a part of which nothing could be read
        raise FileFormatError(
            f"{path.name} is cut short or broken: its pixels cannot be read. Write it again."
        ) from None
    return {name: channel.pixels for name, channel in channels.items()}, dict(header)


def open_rows(path: Path) -> ExrRows:
    """An OpenEXR image to be read some rows at a time.

    Raises
    ------
    FileFormatError
        If the file is missing or is not OpenEXR.
    """
    path = Path(path)
    _check_there(path)
    refuse_deep(path, check_exr(path))
    return ExrRows(path)


def _check_there(path: Path) -> None:
    if not path.is_file():
        raise FileFormatError(f"There is no file {path}. Check the path.")


def write_rgb(
    path: Path,
    image: FloatArray,
    channel_names: Sequence[str] = ("R", "G", "B"),
    header: Mapping[str, str] | None = None,
) -> None:
    """Write an image (H, W, 3) as 32-bit float channels of the given names."""
    write_channels(
        path,
        {name: np.asarray(image[..., index], np.float32) for index, name in enumerate(channel_names)},
        header,
    )


def read_rgb(path: Path, channel_names: Sequence[str] = ("R", "G", "B")) -> FloatArray:
    """Read three channels of an OpenEXR image, (H, W, 3) float32.

    Raises
    ------
    FileFormatError
        If the file is missing, not OpenEXR, or has no such channels.
    """
    channels, _ = read_channels(path)
    if any(name not in channels for name in channel_names):
        raise FileFormatError(
            f"{Path(path).name} has no channels {', '.join(channel_names)}, but {', '.join(sorted(channels)[:8])}."
        )
    return np.stack([np.asarray(channels[name], np.float32) for name in channel_names], axis=-1)
