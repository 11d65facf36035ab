"""Photographs of every usual kind as linear camera RGB.

What each kind of file is taken to hold:

- Camera raw (whatever LibRaw reads): linear camera RGB, demosaiced, black subtracted, no white balance, no
  gamma.
- 16-bit TIFF and PNG: linear camera RGB as a raw converter writes it, 65535 = saturation.
- OpenEXR, Radiance HDR and floating-point TIFF: radiance, which never clips.
- 8-bit JPEG, PNG and TIFF: display-referred; the sRGB curve is undone, which recovers scene-linear values
  only roughly (in-camera tone curves differ from sRGB by up to an exposure step in shadows and highlights).
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import PhotographError
from ..model import BoolArray, Exposure, FloatArray, Photograph

SRGB_CLIP_CODE = 250
"""8-bit codes from here on count as clipped. JPEG's block coding and chroma subsampling move a saturated
255 by up to five codes, and a tone curve's shoulder squeezes the last half exposure step into the same few
codes."""

SIXTEEN_BIT_CLIP = 0.99
"""Share of 65535 from which a 16-bit file counts as clipped: demosaicing and resampling ring by about a
hundredth."""

EXIF_IFD = 0x8769
EXIF_TIME, EXIF_F_NUMBER, EXIF_ISO, EXIF_FOCAL, EXIF_FOCAL_35MM, EXIF_ORIENTATION = (
    0x829A, 0x829D, 0x8827, 0x920A, 0xA405, 0x0112,
)  # fmt: skip

ENCODED_SUFFIXES = frozenset({".jpg", ".jpeg", ".png", ".tif", ".tiff"})
FLOAT_SUFFIXES = frozenset({".exr", ".hdr", ".pic"})


def read_photograph(path: Path) -> Photograph:
    """Read one photograph as linear camera RGB, upright as its orientation tag says.

    Parameters
    ----------
    path
        Camera raw, TIFF, PNG, JPEG, OpenEXR or Radiance HDR.

    Returns
    -------
    Photograph
        Pixels (H, W, 3) float32 with 1 = saturation (radiance for EXR and HDR), the clipped mask, and what
        the file says of its exposure and lens.

    Raises
    ------
    PhotographError
        The file is missing, broken, grey or of no known kind.
    """
    path = Path(path)
    if not path.is_file():
        raise PhotographError(f"There is no photograph {path}. Check the name in the capture file.")
    suffix = path.suffix.lower()
    if suffix == ".exr":
        return _read_exr(path)
    if suffix in FLOAT_SUFFIXES:
        return _read_with_opencv(path, None)
    if suffix in ENCODED_SUFFIXES:
        return _read_encoded(path)
    from .raw import read_raw

    return read_raw(path)


def srgb_to_linear(encoded: FloatArray) -> FloatArray:
    """Undo the sRGB curve (IEC 61966-2-1): encoded and linear values in 0..1, any shape.

    Examples
    --------
    >>> [round(float(value), 4) for value in srgb_to_linear(np.array([0.0, 0.5, 1.0]))]
    [0.0, 0.214, 1.0]
    """
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def exposure_from_exif(exif: Mapping[int, Any]) -> Exposure | None:
    """Exposure from EXIF tags; None without a positive time. A missing ISO is 100, a missing f-number 1.

    Examples
    --------
    >>> exposure_from_exif({0x829A: 0.01, 0x8827: 200, 0x829D: 2.0})
    Exposure(time_s=0.01, iso=200.0, f_number=2.0)
    >>> exposure_from_exif({0x8827: 200}) is None
    True
    """
    time_s = positive_tag(exif, EXIF_TIME)
    if time_s is None:
        return None
    return Exposure(time_s, positive_tag(exif, EXIF_ISO) or 100.0, positive_tag(exif, EXIF_F_NUMBER) or 1.0)


def positive_tag(exif: Mapping[int, Any], tag: int) -> float | None:
    """The value of a tag as a positive number (the first one where it holds several), or None."""
    value = exif.get(tag)
    if isinstance(value, tuple):
        value = value[0] if value else None
    if value is None:
        return None
    try:
        number = float(value)
    except (
        TypeError,
        ValueError,
        ZeroDivisionError,
    ):  # EXIF rationals may be 0/0, and some writers store text
        return None
    return number if np.isfinite(number) and number > 0.0 else None


def exif_of_tiff(path: Path) -> Mapping[int, Any]:
    """EXIF tags of a TIFF-structured file (TIFF itself, DNG, NEF, ARW, CR2), empty where it has none."""
    from PIL import Image

    data = path.read_bytes()
    if data[:4] not in (b"II*\0", b"MM\0*"):
        return {}
    exif = Image.Exif()
    try:
        exif.load(data)
        return {**exif, **exif.get_ifd(EXIF_IFD)}
    except (OSError, SyntaxError, ValueError, KeyError, TypeError, IndexError):
        # Pillow gives up on directories it does not know. Exposure and lens are then as good as absent.
        return {}


def _read_encoded(path: Path) -> Photograph:
    """JPEG, PNG and TIFF: 8 bits through Pillow; deeper through OpenCV, since Pillow cuts them to 8."""
    from PIL import Image

    header = path.read_bytes()[:32]
    if header[:8] == b"\x89PNG\r\n\x1a\n":
        deep = header[24:25] == b"\x10"  # the bit depth of the IHDR chunk
    else:
        deep = header[:4] in (b"II*\0", b"MM\0*") and _tiff_bits(path) != 8
    try:
        if deep:
            return _read_with_opencv(path, _exif_of(path))
        with Image.open(path) as image:
            return _read_eight_bit(path, image)
    except (OSError, SyntaxError, Image.DecompressionBombError) as error:
        raise PhotographError(_broken(path)) from error


def _exif_of(path: Path) -> Mapping[int, Any]:
    """EXIF tags of a TIFF or PNG, empty where it has none."""
    from PIL import Image

    if path.suffix.lower() != ".png":
        return exif_of_tiff(path)
    with Image.open(path) as image:
        exif = image.getexif()
        return {**exif, **exif.get_ifd(EXIF_IFD)}


def _tiff_bits(path: Path) -> int:
    bits = positive_tag(exif_of_tiff(path), 258)
    return 8 if bits is None else int(bits)


def _read_eight_bit(path: Path, image: Any) -> Photograph:
    from PIL import ImageOps

    exif_object = image.getexif()
    exif = {**exif_object, **exif_object.get_ifd(EXIF_IFD)}
    if image.mode not in ("RGB", "RGBA", "P", "CMYK", "YCbCr"):
        raise PhotographError(_grey(path))
    profile = image.info.get("icc_profile")
    image.load()  # before the transposition, so that a broken file fails here and not half read
    upright = ImageOps.exif_transpose(image).convert("RGB")
    if profile:
        upright = _to_srgb(upright, profile)
    codes = np.asarray(upright)
    table = srgb_to_linear(np.arange(256) / 255.0).astype(np.float32)
    return Photograph(
        path=path,
        pixels=table[codes],
        clipped=codes.max(axis=-1) >= SRGB_CLIP_CODE,
        exposure=exposure_from_exif(exif),
        focal_mm=positive_tag(exif, EXIF_FOCAL),
        focal_35mm=positive_tag(exif, EXIF_FOCAL_35MM),
        display_referred=True,
    )


def _to_srgb(image: Any, profile: bytes) -> Any:
    """An image with a colour profile (Display P3, Adobe RGB) in sRGB; unreadable profiles are ignored."""
    from PIL import ImageCms

    try:
        source = ImageCms.ImageCmsProfile(io.BytesIO(profile))
        if "srgb" in ImageCms.getProfileDescription(source).lower():
            return image
        return ImageCms.profileToProfile(image, source, ImageCms.createProfile("sRGB"), outputMode="RGB")
    except (ImageCms.PyCMSError, OSError):
        return image


def _read_with_opencv(path: Path, exif: Mapping[int, Any] | None) -> Photograph:
    """16-bit PNG and TIFF (linear camera RGB), and float TIFF and Radiance HDR (radiance)."""
    import cv2

    # From a buffer: imread fails on names outside the code page on Windows.
    buffer = np.frombuffer(path.read_bytes(), np.uint8)
    try:
        stored = cv2.imdecode(buffer, cv2.IMREAD_UNCHANGED) if len(buffer) else None
    except cv2.error as error:
        raise PhotographError(_broken(path)) from error
    if stored is None:
        raise PhotographError(_broken(path))
    if stored.ndim != 3 or stored.shape[-1] < 3:
        raise PhotographError(_grey(path))
    rgb = stored[..., 2::-1]
    if stored.dtype in (np.float32, np.float64):
        return _radiance(path, rgb)
    if stored.dtype != np.uint16:
        raise PhotographError(
            f"{path.name} holds {stored.dtype} values. Save it as 8 or 16-bit integers or as OpenEXR."
        )
    pixels = np.ascontiguousarray(rgb, np.float32) / np.float32(65535.0)
    tags = exif or {}
    orientation = int(positive_tag(tags, EXIF_ORIENTATION) or 1)
    # OpenCV turns no 16-bit picture by itself when it is read unchanged.
    pixels = upright(pixels, orientation)
    return Photograph(
        path=path,
        pixels=pixels,
        clipped=pixels.max(axis=-1) >= SIXTEEN_BIT_CLIP,
        exposure=exposure_from_exif(tags),
        focal_mm=positive_tag(tags, EXIF_FOCAL),
        focal_35mm=positive_tag(tags, EXIF_FOCAL_35MM),
    )


def upright(image: npt.NDArray[Any], orientation: int) -> npt.NDArray[Any]:
    """Turn an image (H, W, ...) as its EXIF orientation (1-8) asks; unknown values leave it alone.

    Examples
    --------
    >>> upright(np.array([[1, 2], [3, 4]]), 6)  # the camera was turned: the first row is the right column
    array([[3, 1],
           [4, 2]])
    """
    turned = {
        2: lambda a: a[:, ::-1],
        3: lambda a: a[::-1, ::-1],
        4: lambda a: a[::-1],
        5: lambda a: a.swapaxes(0, 1),
        6: lambda a: np.rot90(a, -1),
        7: lambda a: a[::-1, ::-1].swapaxes(0, 1),
        8: lambda a: np.rot90(a, 1),
    }
    if orientation not in turned:
        return image
    return np.ascontiguousarray(turned[orientation](image))


def _read_exr(path: Path) -> Photograph:
    import OpenEXR

    try:
        channels = OpenEXR.File(str(path), separate_channels=True).channels()
    except (RuntimeError, ValueError, OSError) as error:
        raise PhotographError(_broken(path)) from error
    if not {"R", "G", "B"} <= set(channels):
        raise PhotographError(_grey(path))
    planes = [np.asarray(channels[name].pixels, np.float32) for name in "RGB"]
    if len({plane.shape for plane in planes}) != 1:
        raise PhotographError(f"{path.name} has channels of different sizes. Save R, G and B at full size.")
    return _radiance(path, np.stack(planes, axis=-1))


def _radiance(path: Path, rgb: npt.NDArray[Any]) -> Photograph:
    """Radiance never clips; only pixels that are not finite numbers count as clipped, and hold 0."""
    finite = np.isfinite(rgb).all(axis=-1)
    pixels = np.where(finite[..., None], rgb, 0.0).astype(np.float32)
    return Photograph(path=path, pixels=pixels, clipped=~finite, scene_referred_float=True)


def neighbourhood(mask: BoolArray, radius_px: int) -> BoolArray:
    """True within `radius_px` (square) of a True pixel: all pixels that an interpolation of it may use."""
    import cv2

    if radius_px <= 0 or not mask.any():
        return mask
    kernel = np.ones((2 * radius_px + 1, 2 * radius_px + 1), np.uint8)
    return np.asarray(cv2.dilate(mask.astype(np.uint8), kernel) > 0)


def _broken(path: Path) -> str:
    return f"{path.name} cannot be read: it is broken or not what its name says. Export or copy it again."


def _grey(path: Path) -> str:
    return f"{path.name} has no colour. Save the photograph with red, green and blue channels."
