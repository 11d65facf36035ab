"""What a photograph's file really is, and whether all of it is there, from its first bytes and its own table of contents.

Looked at before a library decodes it: some decode half a picture and call it whole, some allocate what a damaged header
claims, and most write lines of their own to the terminal.
"""

from __future__ import annotations

import warnings
import zlib
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from ..errors import FileFormatError, PhotographError
from . import suffixes

if TYPE_CHECKING:
    from ..files.exr_limits import ExrPart

type Kind = Literal["JPEG", "PNG", "TIFF", "OpenEXR", "Radiance HDR", "raw", "other"]
type Bytes = npt.NDArray[np.uint8]

LARGEST_PX = 256_000_000
"""Pixels a photograph may have: 3 GB as linear RGB. No camera takes more in one exposure."""

MOST_PX_PER_BYTE = 2000
"""Pixels for each byte of the file: no codec packs a picture tighter (deflate reaches 1032 bytes for one)."""

_SUFFIXES: dict[Kind, tuple[str, ...]] = {
    "JPEG": suffixes.JPEG,
    "PNG": suffixes.PNG,
    "TIFF": suffixes.TIFF,
    "OpenEXR": suffixes.OPEN_EXR,
    "Radiance HDR": suffixes.RADIANCE_HDR,
    "raw": suffixes.RAW,
}
_SIGNATURES: tuple[tuple[bytes, Kind], ...] = (
    (b"\xff\xd8\xff", "JPEG"),
    (b"\x89PNG\r\n\x1a\n", "PNG"),
    (b"II*\0", "TIFF"),
    (b"MM\0*", "TIFF"),
    (b"II+\0", "TIFF"),
    (b"MM\0+", "TIFF"),
    (b"\x76\x2f\x31\x01", "OpenEXR"),
    (b"#?RADIANCE", "Radiance HDR"),
    (b"#?RGBE", "Radiance HDR"),
)
_FOREIGN = {
    (0, b"GIF8"): "GIF",
    (0, b"BM"): "BMP",
    (8, b"WEBP"): "WebP",
    (0, b"%PDF"): "PDF",
    (4, b"ftyphei"): "HEIC",
    (4, b"ftypmif1"): "HEIC",
    (4, b"ftypavif"): "AVIF",
    (0, b"\0\0\0\x0cjP"): "JPEG 2000",
    (0, b"\0\0\0\x0cJXL"): "JPEG XL",
    (0, b"8BPS"): "Photoshop",
}


def file_kind(path: Path) -> Kind:
    """What a photograph is by its content, which its name must agree with; "raw" is whatever is left to LibRaw.

    A wrong name is refused rather than seen through: raw, display-referred and radiance files are taken to mean different
    things, and whoever named a JPEG .dng expects the sensor's own values.

    Raises
    ------
    PhotographError
        If the file is missing, a folder, unreadable, empty, of no known kind, or of another than its name says.
    """
    head = _head(path)
    if not head:
        raise PhotographError(f"{path.name} cannot be read: it is empty (0 bytes). Copy or export it again.")
    suffix = path.suffix.lower()
    named = next((kind for kind, known in _SUFFIXES.items() if suffix in known), None)
    found = next((kind for signature, kind in _SIGNATURES if head.startswith(signature)), None)
    foreign = next((name for (at, mark), name in _FOREIGN.items() if head[at:].startswith(mark)), None)
    if found is None and foreign is not None:
        raise PhotographError(
            f"{path.name} is a {foreign} picture, which is not read here. Export it as raw, TIFF, PNG, JPEG, EXR or HDR."
        )
    if found is None:
        if named not in (None, "raw"):
            raise PhotographError(broken(path))
        return "raw"
    if found == "TIFF" and named in (None, "raw"):
        return "raw" if named else found  # DNG, NEF, ARW and others are built as TIFF
    if named is not None and named != found:
        raise PhotographError(misnamed(path, found))
    return found


def _head(path: Path) -> bytes:
    """The first bytes of a file."""
    if path.is_dir():
        raise PhotographError(f"{path} is a folder. Give the photographs in it.")
    if path.exists() and not path.is_file():  # a pipe would be waited for
        raise PhotographError(f"{path.name} is no file but a device. Give a photograph.")
    try:
        with path.open("rb") as file:
            return file.read(64)
    except FileNotFoundError:
        raise PhotographError(f"There is no photograph {path}. Check its name.") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "its name is not valid"
        raise PhotographError(
            f"{path.name} cannot be opened ({reason}). Check its permissions and its disk."
        ) from error


def misnamed(path: Path, found: Kind) -> str:
    """The sentence about a file whose name and content disagree."""
    if found == "raw":
        return (
            f"{path.name} is camera raw, not TIFF as its name says. Rename it to {path.stem}.dng to use it."
        )
    article = "an" if found == "OpenEXR" else "a"
    return (
        f"{path.name} is {article} {found} picture, not what its name says. Rename it to {path.stem}{_SUFFIXES[found][0]} to use "
        "it as that, or give the file you meant."
    )


def broken(path: Path) -> str:
    """The sentence about a damaged file."""
    return f"{path.name} cannot be read: it is broken or not what its name says. Export or copy it again."


def cut_short(path: Path) -> str:
    """The sentence about a file that ends too early."""
    return f"{path.name} cannot be read: it is cut short, the file ends before its picture does. Copy or export it again."


def check_size(path: Path, width: int, height: int) -> None:
    """Refuse a size that is none, larger than memory should be asked for, or more than the file can hold.

    Raises
    ------
    PhotographError
        If so.
    """
    if width < 1 or height < 1:
        raise PhotographError(broken(path))
    if width * height > LARGEST_PX:
        raise PhotographError(
            f"{path.name} says it is {width} x {height} pixels, more than the {LARGEST_PX // 1_000_000} megapixels that are "
            "read. Give a smaller picture, or copy it again if it is not that large."
        )
    if width * height > MOST_PX_PER_BYTE * path.stat().st_size:
        raise PhotographError(cut_short(path))


def check_picture_size(path: Path) -> None:
    """Refuse a picture of any kind, photograph or not, whose header states a size that `check_size` refuses.

    Raises
    ------
    PhotographError
        If so, or if it is no picture that is known.
    """
    from PIL import Image, UnidentifiedImageError

    if not path.stat().st_size:
        raise PhotographError(broken(path))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of large pictures, which are judged here
        try:
            with Image.open(path) as image:
                width, height = image.size
        except (
            UnidentifiedImageError,
            Image.DecompressionBombError,
            OSError,
            SyntaxError,
            ValueError,
        ) as error:
            raise PhotographError(broken(path)) from error
    check_size(path, width, height)


def mapped(path: Path) -> Bytes:
    """The file's bytes, read as they are looked at."""
    return np.memmap(path, np.uint8, mode="r")


def number(data: Bytes, at: int, size: int, order: Literal["little", "big"] = "big") -> int:
    """An unsigned number of `size` bytes.

    Raises
    ------
    EOFError
        If the file ends before it.
    """
    if at < 0 or at + size > len(data):
        raise EOFError
    return int.from_bytes(data[at : at + size].tobytes(), order)


# ---------------------------------------------------------------- JPEG and PNG


def jpeg_size(path: Path) -> tuple[int, int]:
    """Width and height that a JPEG's frame header states.

    Raises
    ------
    PhotographError
        If there is none.
    """
    data = mapped(path)
    at = 2
    try:
        while True:
            marker = number(data, at, 2)
            if marker >> 8 != 0xFF:
                raise PhotographError(broken(path))
            if (
                marker in (0xFFFF, 0xFF01) or 0xFFD0 <= marker <= 0xFFD8
            ):  # fill byte, or a marker without content
                at += 1 if marker == 0xFFFF else 2
                continue
            if 0xFFC0 <= marker <= 0xFFCF and marker not in (0xFFC4, 0xFFC8, 0xFFCC):
                return number(data, at + 7, 2), number(data, at + 5, 2)
            if marker in (0xFFD9, 0xFFDA):
                raise PhotographError(broken(path))
            at += 2 + number(data, at + 2, 2)
    except EOFError:
        raise PhotographError(cut_short(path)) from None


def png_header(path: Path) -> tuple[int, int, int, int]:
    """Width, height, bit depth and colour type of a PNG, every chunk of which is whole and has its checksum.

    Raises
    ------
    PhotographError
        If not.
    """
    data = mapped(path)
    at, kind = 8, b""
    try:
        while kind != b"IEND":
            length, kind = number(data, at, 4), data[at + 4 : at + 8].tobytes()
            if number(data, at + 8 + length, 4) != zlib.crc32(data[at + 4 : at + 8 + length]):
                raise PhotographError(broken(path))
            at += 12 + length
        return number(data, 16, 4), number(data, 20, 4), int(data[24]), int(data[25])
    except EOFError:
        raise PhotographError(cut_short(path)) from None


# ---------------------------------------------------------------- OpenEXR


def check_exr(path: Path) -> tuple[ExrPart, ...]:
    """The parts of an OpenEXR file, whose header is sound and whose last block is all there (`files.exr_limits`).

    Raises
    ------
    PhotographError
        If it is not.
    """
    from ..files import exr_limits

    try:
        parts = exr_limits.exr_parts(path)
        if any(part.deep for part in parts):
            raise PhotographError(f"{path.name} is a deep picture. Flatten it to R, G and B.")
        for part in parts:
            check_size(path, part.width, part.height)
        exr_limits.check_exr(path)
        exr_limits.check_memory(path, parts)
    except FileFormatError as problem:
        raise PhotographError(str(problem)) from None
    return parts
