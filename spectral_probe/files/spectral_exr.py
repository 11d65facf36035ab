"""Spectral images in OpenEXR, one channel a wavelength: the layout of Fichet et al. read and written, Indigo's read.

A. Fichet, R. Pacanowski & A. Wilkie, "An OpenEXR Layout for Spectral Images", JCGT 10(3), 2021: emissive channels
`S0.550,000000nm` (with `S1` to `S3` where the light is polarised), reflective ones `T.550,000000nm`, and bispectral ones
`T.350,000000nm.550,000000nm` (fluorescence), which have no place in our pipeline.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ..errors import FileFormatError, SpectralDataError
from ..large import let_go
from ..model import BoolArray, FloatArray, SpectralPanorama
from ..parallel import in_parallel, row_blocks
from ..spectra.panorama import panorama_spectra
from .image_exr import read_channels, write_rows
from .spectral_channels import SpectralChannels, channel_name, find_channels

type Quantity = Literal["emissive", "reflective"]

KEPT_ATTRIBUTES = (
    "spectralLayoutVersion",
    "emissiveUnits",
    "reflectiveUnits",
    "polarisationHandedness",
    "EV",
    "lensTransmission",
    "cameraResponse",
)
"""Header attributes of the layout. `lensTransmission` and `cameraResponse` are spectra as text (`spectrum_of_text`)."""

EMISSIVE_HEADER = {
    "spectralLayoutVersion": "1.0",
    "polarisationHandedness": "right",
    "emissiveUnits": "W.m^-2.sr^-1.nm^-1",
}
"""Header attributes that make channels such as `S0.550,000000nm` of a larger file a spectral image."""

_UNITS = {"emissive": ("emissiveUnits", "W.m^-2.sr^-1.nm^-1"), "reflective": ("reflectiveUnits", "1")}
_HALF_LIMIT = 6.0e4


@dataclass(frozen=True)
class SpectralImage:
    """A spectral image as its file holds it: its own wavelengths, its own unit.

    Parameters
    ----------
    spectra
        (H, W, L) float32.
    wavelengths_nm
        (L,) ascending.
    valid
        (H, W), False where the file says so (channel `valid`) or a value is not finite.
    quantity
        "emissive" (radiance) or "reflective".
    attributes
        Those of `KEPT_ATTRIBUTES` that the header has.
    remarks
        Sentences on what of the file was not used.
    """

    spectra: FloatArray
    wavelengths_nm: FloatArray
    valid: BoolArray
    quantity: Quantity = "emissive"
    attributes: Mapping[str, Any] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()


def write_spectral_panorama(path: Path, panorama: SpectralPanorama) -> None:
    """Write the spectra of a panorama, with its `valid` mask as a further channel."""
    names = [channel_name(float(nm)) for nm in panorama.wavelengths_nm]
    height, width = panorama.valid.shape

    def brightest_of(rows: slice) -> float:
        brightest = float(np.abs(panorama_spectra(panorama, rows)).max())
        let_go(panorama.weights)
        return brightest

    kind = _kind(max(in_parallel(brightest_of, row_blocks(width, height))))

    def channels(rows: slice) -> dict[str, Any]:
        made = dict(zip(names, panorama_spectra(panorama, rows).astype(kind), strict=True))
        let_go(panorama.weights)
        return made | {"valid": panorama.valid[rows].astype(kind)}

    comment = "Relative spectral radiance: the scale is that of the photographs' exposures."
    write_rows(path, (height, width), channels, _layout("emissive") | {"comment": comment})


def write_spectral(
    path: Path,
    spectra: FloatArray,
    wavelengths_nm: FloatArray,
    valid: BoolArray | None = None,
    *,
    quantity: Quantity = "emissive",
    attributes: Mapping[str, Any] | None = None,
) -> None:
    """Write a spectral image (H, W, L) on any wavelengths (L,).

    Parameters
    ----------
    path
        The file.
    spectra
        (H, W, L).
    wavelengths_nm
        (L,), in any order.
    valid
        (H, W), written as a further channel.
    quantity
        "emissive" for radiance, channels `S0`; "reflective" for reflectance, channels `T`.
    attributes
        Further header attributes, such as {"EV": 0.5}; they replace the usual ones of the same name.

    Raises
    ------
    SpectralDataError
        If the spectra do not fit their wavelengths, or two wavelengths are the same.
    """
    spectra = np.asarray(spectra)
    if spectra.ndim != 3 or spectra.shape[-1] != len(wavelengths_nm):
        raise SpectralDataError(
            f"A spectral image of shape {spectra.shape} does not fit {len(wavelengths_nm)} wavelengths. "
            "Give rows x columns x wavelengths."
        )
    component = "S0" if quantity == "emissive" else "T"
    planes = {
        channel_name(float(nm), component): spectra[..., index] for index, nm in enumerate(wavelengths_nm)
    }
    if len(planes) < len(wavelengths_nm):
        raise SpectralDataError("Two wavelengths of the spectral image are the same. Give each once.")
    kind = _kind(max(float(np.abs(plane).max()) for plane in planes.values()))

    def channels(rows: slice) -> dict[str, Any]:
        made = {name: plane[rows].astype(kind) for name, plane in planes.items()}
        return made if valid is None else made | {"valid": valid[rows].astype(kind)}

    height, width = spectra.shape[:2]
    write_rows(path, (height, width), channels, {**_layout(quantity), **(attributes or {})})


def _kind(brightest: float) -> type[np.floating[Any]]:
    """16-bit channels where they can hold the range (a 2048 x 1024 panorama is 256 MB so), else 32-bit."""
    return np.float16 if 1.0 < brightest < _HALF_LIMIT else np.float32


def _layout(quantity: Quantity) -> dict[str, Any]:
    unit_name, unit = _UNITS[quantity]
    return {"spectralLayoutVersion": "1.0", "polarisationHandedness": "right", unit_name: unit}


def read_spectral(path: Path) -> tuple[FloatArray, FloatArray]:
    """Spectra (H, W, L) float32 and wavelengths (L,) in nm of a spectral image; see `read_spectral_image`."""
    image = read_spectral_image(path)
    return image.spectra, image.wavelengths_nm


def read_spectral_image(path: Path, quantity: Quantity | None = None) -> SpectralImage:
    """Read a spectral image in the layout of Fichet et al., or with Indigo's channels.

    Parameters
    ----------
    path
        The file.
    quantity
        Which of the two to read where a file holds both; None: the emissive part if there is one.

    Raises
    ------
    FileFormatError
        If the file is missing, has no such channels, is bispectral, or its channels contradict each other.

    Notes
    -----
    Values are as the file has them. Of polarised light the intensity S0 is read. Indigo's bucket `wavelength400` starts
    at 400 nm; its wavelength here is the bucket's middle.
    """
    planes, header = read_channels(path)
    return spectral_image(planes, header, Path(path).name, quantity)


def spectral_image(
    planes: Mapping[str, Any], header: Mapping[str, Any], name: str, quantity: Quantity | None = None
) -> SpectralImage:
    """The spectral image among the channels (H, W) of a file that is already read; see `read_spectral_image`."""
    found = find_channels(planes, name)
    remarks = []
    if found.bispectral:
        raise FileFormatError(
            f"{name} is bispectral (fluorescence): light of one wavelength leaves as another. "
            "Give an emissive or reflective spectral image."
        )
    if quantity is None:
        quantity = "emissive" if found.emissive else "reflective"
    chosen = found.emissive if quantity == "emissive" else found.reflective
    if not chosen:
        raise FileFormatError(_nothing_found(found, name, quantity))
    if found.polarised:
        remarks.append(f"{name} is polarised: its intensity S0 is used, S1 to S3 are not.")
    if quantity == "emissive" and found.reflective:
        remarks.append(f"{name} holds reflectances too; its emissive part is used.")
    if len({np.shape(planes[channel]) for channel in chosen.values()}) > 1:
        raise FileFormatError(f"The channels of {name} differ in size. Write it without subsampling.")
    wavelengths_nm = np.array(sorted(chosen))
    spectra = np.stack([np.asarray(planes[chosen[nm]], np.float32) for nm in wavelengths_nm], axis=-1)
    valid = np.ones(spectra.shape[:2], bool)
    for channel in chosen.values():  # one at a time: little memory
        valid &= np.isfinite(planes[channel])
    if "valid" in planes:
        valid &= np.asarray(planes["valid"]) > 0.5
    attributes = {key: header[key] for key in KEPT_ATTRIBUTES if key in header}
    return SpectralImage(spectra, wavelengths_nm, valid, quantity, attributes, tuple(remarks))


def _nothing_found(found: SpectralChannels, name: str, quantity: Quantity) -> str:
    if found.emissive or found.reflective:
        other = "reflectances" if found.reflective else "radiance"
        return f"{name} holds {other}, but no {quantity} channels. Give a file that has them."
    return f"{name} is no spectral image: it has no channels such as S0.550,000000nm, T.550,000000nm or wavelength550."
