"""Photographs of every usual kind as linear camera RGB.

What each kind of file is taken to hold:

- Camera raw (whatever LibRaw reads): linear camera RGB, demosaiced, black subtracted, no white balance, no
  gamma.
- 16-bit TIFF and PNG: linear camera RGB as a raw converter writes it, 65535 = saturation; with a colour profile (or PNG's
  own words) whose curve is not linear: display-referred, brought to linear Rec.709 by that profile.
- OpenEXR, Radiance HDR and floating-point TIFF: radiance, which never clips.
- 8-bit JPEG, PNG and TIFF: display-referred; the sRGB curve is undone, which recovers scene-linear values
  only roughly (in-camera tone curves differ from sRGB by up to an exposure step in shadows and highlights).

An alpha channel is left aside: photographs have none. CMYK is refused: inks are no measure of light.
"""

from __future__ import annotations

import io
import struct
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from ..errors import PhotographError
from ..files.silence import libraries_silenced
from ..model import BoolArray, FloatArray, Photograph
from .exif import EXIF_IFD, EXIF_ORIENTATION, lens_and_exposure, positive_tag
from .file_kind import Kind, broken, check_size, file_kind, jpeg_size, mapped, misnamed, png_header
from .profile import ColourProfile, gamma_profile, read_profile
from .radiance import radiance_photograph, read_exr
from .tiff import Directory, check_tiff, exif_of_tiff

SRGB_CLIP_CODE = 250
"""8-bit codes from here on count as clipped. JPEG's block coding and chroma subsampling move a saturated
255 by up to five codes, and a tone curve's shoulder squeezes the last half exposure step into the same few
codes."""

SIXTEEN_BIT_CLIP = 0.99
"""Share of 65535 from which a 16-bit file counts as clipped: demosaicing and resampling ring by about a
hundredth."""

_CMYK, _LAB = (5,), (8, 9, 10)  # TIFF's photometric interpretations
_ICC_PROFILE = 34675


def read_photograph(path: Path, *, half_size: bool = False, grey: bool = False) -> Photograph:
    """Read one photograph as linear camera RGB, upright as its orientation tag says.

    Parameters
    ----------
    path
        Camera raw, TIFF, PNG, JPEG, OpenEXR or Radiance HDR.
    half_size
        Camera raw at half the size, each pixel from its own 2 x 2 sensels without interpolation; other kinds of files
        are not changed.
    grey
        Take a picture without colour too, the same value in all three channels (for boards, not for light).

    Returns
    -------
    Photograph
        Pixels (H, W, 3) float32 with 1 = saturation (radiance for EXR and HDR), the clipped mask, and what
        the file says of its exposure and lens.

    Raises
    ------
    PhotographError
        The file is missing, broken, cut short, grey, of no known kind or of another than its name says.
    """
    path = Path(path)
    kind = file_kind(path)
    if kind == "raw":
        from .raw import read_raw

        return read_raw(path, half_size=half_size)
    if kind == "OpenEXR":
        return read_exr(path, grey=grey)
    if kind == "Radiance HDR":
        return _read_hdr(path)
    if kind == "TIFF":
        return _read_tiff(path, grey=grey)
    if kind == "PNG":
        width, height, bits, _ = png_header(path)
        check_size(path, width, height)
        if bits == 16:
            exif, profile = _tags_of_png(path)
            orientation = int(positive_tag(exif, EXIF_ORIENTATION) or 1)
            return _read_sixteen_bit(path, exif, profile, orientation, grey=grey)
    else:
        check_size(path, *jpeg_size(path))
    return _read_eight_bit(path, kind, grey=grey)


def srgb_to_linear(encoded: FloatArray) -> FloatArray:
    """Undo the sRGB curve (IEC 61966-2-1): encoded and linear values in 0..1, any shape.

    Examples
    --------
    >>> [round(float(value), 4) for value in srgb_to_linear(np.array([0.0, 0.5, 1.0]))]
    [0.0, 0.214, 1.0]
    """
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


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


def neighbourhood(mask: BoolArray, radius_px: int) -> BoolArray:
    """True within `radius_px` (square) of a True pixel: all pixels that an interpolation of it may use."""
    if radius_px <= 0 or not mask.any():
        return mask
    kernel = np.ones((2 * radius_px + 1, 2 * radius_px + 1), np.uint8)
    return np.asarray(cv2.dilate(mask.view(np.uint8), kernel)).view(bool)


# ---------------------------------------------------------------- 8 bits, through Pillow


def _read_eight_bit(path: Path, kind: Kind, *, grey: bool) -> Photograph:
    """JPEG, PNG or TIFF of 8 bits."""
    # Pillow warns of what it mends or of what is odd in tags. What matters is checked here, and becomes an error or nothing.
    with warnings.catch_warnings(), path.open("rb") as file:
        warnings.simplefilter("ignore")
        try:
            image = _pillow_image(kind, file)
            _check_colour(path, image.mode, grey=grey)
            with libraries_silenced():
                image.load()
            exif = _exif(image)
            profile = image.info.get("icc_profile")
            image = image.convert("RGB") if image.mode != "RGB" else image
            if profile:
                image = _to_srgb(image, profile)
        except (
            OSError,
            SyntaxError,
            ValueError,
            EOFError,
            struct.error,
            MemoryError,
            IndexError,
            TypeError,
        ) as error:
            raise PhotographError(broken(path)) from error
        codes = np.asarray(image)
        image.close()
    codes = upright(codes, int(positive_tag(exif, EXIF_ORIENTATION) or 1))
    table = srgb_to_linear(np.arange(256) / 255.0).astype(np.float32)
    return Photograph(
        path=path,
        pixels=np.asarray(cv2.LUT(codes, table)),
        clipped=brightest(codes) >= SRGB_CLIP_CODE,
        display_referred=True,
        **lens_and_exposure(exif),
    )


def _pillow_image(kind: Kind, file: Any) -> Any:
    """An image of the kind that the file is known to be, its pixels not read yet.

    `Image.open` would refuse 179 megapixels and warn of 90; sizes are checked before.
    """
    from PIL import JpegImagePlugin, PngImagePlugin, TiffImagePlugin

    readers: dict[str, Any] = {
        "JPEG": JpegImagePlugin.JpegImageFile,
        "PNG": PngImagePlugin.PngImageFile,
        "TIFF": TiffImagePlugin.TiffImageFile,
    }
    return readers[kind](file)


def _check_colour(path: Path, mode: str, *, grey: bool) -> None:
    """Refuse modes of Pillow that are no red, green and blue."""
    if mode in ("RGB", "RGBA", "RGBX", "P", "PA", "YCbCr") or (grey and mode in ("1", "L", "LA")):
        return
    if mode == "1":
        raise PhotographError(
            f"{path.name} is black and white without tones (1 bit). Save the photograph in colour, with 8 or 16 bits."
        )
    if mode == "CMYK":
        raise PhotographError(_cmyk(path))
    if mode in ("LAB", "HSV"):
        raise PhotographError(f"{path.name} is in {mode.title()}, not RGB. Save it as RGB.")
    raise PhotographError(_grey(path))


def _exif(image: Any) -> Mapping[int, Any]:
    """EXIF tags of a Pillow image, empty where they cannot be read."""
    try:
        exif = image.getexif()
        return {**exif, **exif.get_ifd(EXIF_IFD)}
    except (OSError, SyntaxError, ValueError, KeyError, TypeError, IndexError, OverflowError, struct.error):
        return {}  # exposure and lens are then as good as absent


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


# ---------------------------------------------------------------- deeper, through OpenCV


def _read_tiff(path: Path, *, grey: bool) -> Photograph:
    """TIFF of any depth."""
    found = check_tiff(path)
    first = found[0]
    if any(directory.raw for directory in found):
        raise PhotographError(misnamed(path, "raw"))
    _check_tiff_colour(path, first, grey=grey)
    if first.bits == 8:
        return _read_eight_bit(path, "TIFF", grey=grey)
    exif = exif_of_tiff(path)
    if first.floating and first.bits in (32, 64):
        return radiance_photograph(path, _decoded(path, grey=grey), **lens_and_exposure(exif))
    if first.bits != 16 or first.floating:
        raise PhotographError(
            f"{path.name} holds {first.bits}-bit {'floating-point' if first.floating else 'integer'} values. Save it as 8 or "
            "16-bit integers or as OpenEXR."
        )
    # OpenCV turns every TIFF upright by itself, and never a PNG that it reads unchanged.
    stored = exif.get(_ICC_PROFILE)
    profile = read_profile(stored) if isinstance(stored, bytes) else None
    return _read_sixteen_bit(path, exif, profile, 1, grey=grey)


def _check_tiff_colour(path: Path, directory: Directory, *, grey: bool) -> None:
    if directory.photometric in _CMYK:
        raise PhotographError(_cmyk(path))
    if directory.photometric in _LAB:
        _check_colour(path, "LAB", grey=grey)
    if directory.bits == 1:
        _check_colour(path, "1", grey=grey)
    if directory.photometric in (0, 1) and not grey:
        raise PhotographError(_grey(path))


def _read_sixteen_bit(
    path: Path, exif: Mapping[int, Any], profile: ColourProfile | None, orientation: int, *, grey: bool
) -> Photograph:
    """16-bit PNG or TIFF, to be turned as `orientation` asks: linear camera RGB unless its profile says otherwise."""
    stored = _decoded(path, grey=grey)
    if stored.dtype != np.uint16:
        raise PhotographError(broken(path))
    encoded = profile is not None and not profile.linear
    if profile is not None and encoded:
        pixels = profile.to_rec709(stored)
        clipped = brightest(stored) >= SRGB_CLIP_CODE * 257
    else:
        pixels = np.multiply(stored, np.float32(1.0 / 65535.0), dtype=np.float32)
        clipped = brightest(stored) >= SIXTEEN_BIT_CLIP * 65535.0
    return Photograph(
        path=path,
        pixels=upright(pixels, orientation),
        clipped=upright(clipped, orientation),
        display_referred=encoded,
        **lens_and_exposure(exif),
    )


def _decoded(path: Path, *, grey: bool) -> npt.NDArray[Any]:
    """What OpenCV reads, as R, G, B (H, W, 3)."""
    with opencv_silent():
        try:
            # From a buffer: imread fails on names outside the code page on Windows.
            stored = cv2.imdecode(mapped(path), cv2.IMREAD_UNCHANGED)
        except cv2.error as error:
            raise PhotographError(broken(path)) from error
    if stored is None:
        raise PhotographError(broken(path))
    if stored.ndim == 3 and stored.shape[-1] >= 3:
        return np.asarray(stored[..., 2::-1])
    if not grey:
        raise PhotographError(_grey(path))
    plane = stored if stored.ndim == 2 else stored[..., 0]
    return np.repeat(plane[..., None], 3, axis=-1)


def _read_hdr(path: Path) -> Photograph:
    """Radiance HDR; the size is looked at first, since the decoder allocates what the file claims."""
    head = mapped(path)[:65536].tobytes()
    line = next(
        (line for line in head.split(b"\n") if line.startswith((b"-Y ", b"+Y ", b"-X ", b"+X "))), b""
    )
    words = line.split()
    if len(words) != 4 or not (words[1].isdigit() and words[3].isdigit()):
        raise PhotographError(broken(path))
    if words[0] != b"-Y" or words[2] != b"+X":
        raise PhotographError(f"{path.name} is stored turned or mirrored. Save it upright, or as OpenEXR.")
    check_size(path, int(words[3][:9]), int(words[1][:9]))
    return radiance_photograph(path, _decoded(path, grey=False))


@contextmanager
def opencv_silent() -> Iterator[None]:
    """OpenCV's log off, and its libraries': what they have to say of a broken file is said by the error."""
    before = cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        with libraries_silenced():
            yield
    finally:
        cv2.utils.logging.setLogLevel(before)


def _tags_of_png(path: Path) -> tuple[Mapping[int, Any], ColourProfile | None]:
    """EXIF tags of a PNG, and its profile: an embedded one, sRGB, or a power."""
    from PIL import PngImagePlugin

    with warnings.catch_warnings(), path.open("rb") as file:
        warnings.simplefilter("ignore")
        try:
            image = PngImagePlugin.PngImageFile(file)
            exif, info = _exif(image), image.info
        except (OSError, SyntaxError, ValueError, struct.error):
            return {}, None
    if isinstance(info.get("icc_profile"), bytes):
        return exif, read_profile(info["icc_profile"])
    if "srgb" in info:
        return exif, gamma_profile(None)
    gamma = info.get("gamma")
    return exif, gamma_profile(gamma) if isinstance(gamma, float) and 0.2 < gamma < 5.0 else None


def brightest(pixels: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The largest of the three channels, (H, W, 3) -> (H, W); three times as fast as the maximum along a short axis."""
    return np.asarray(np.maximum(np.maximum(pixels[..., 0], pixels[..., 1]), pixels[..., 2]))


def _cmyk(path: Path) -> str:
    return f"{path.name} is in CMYK, amounts of ink, from which light cannot be told. Save the photograph as RGB."


def _grey(path: Path) -> str:
    return f"{path.name} has no colour. Save the photograph with red, green and blue channels."
