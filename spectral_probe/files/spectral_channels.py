"""The names of the channels of spectral images, and the spectra that stand as text in their headers.

Names and text are those of Fichet, Pacanowski & Wilkie, "An OpenEXR Layout for Spectral Images", JCGT 10(3), 2021; and
Indigo Renderer's `wavelength430_25`, from its technical reference, "Spectral Input and Output".
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from ..errors import FileFormatError
from ..model import FloatArray

_LIGHT_SPEED_M_S = 299_792_458.0
_MULTIPLIERS = {
    "Y": 1e24, "Z": 1e21, "E": 1e18, "P": 1e15, "T": 1e12, "G": 1e9, "M": 1e6, "k": 1e3, "h": 1e2, "da": 1e1, "": 1.0,
    "d": 1e-1, "c": 1e-2, "m": 1e-3, "u": 1e-6, "n": 1e-9, "p": 1e-12,
}  # fmt: skip
# The layout's own expression has a decimal comma (a point would be a layer in OpenEXR); files with a point exist.
_QUANTITY = (
    r"(\d+[.,]?\d*(?:[Ee][+-]?\d+)?|[.,]\d+(?:[Ee][+-]?\d+)?)(Y|Z|E|P|T|G|M|k|h|da|d|c|m|u|n|p)?(m|Hz)"
)
_LAYER = r"(?:(?P<layer>.+)\.)?"
_CHANNEL = re.compile(rf"{_LAYER}(?P<component>S[0-3]|T)\.{_QUANTITY}")
_BISPECTRAL = re.compile(rf"{_LAYER}T\.{_QUANTITY}\.{_QUANTITY}")
_INDIGO = re.compile(rf"{_LAYER}wavelength(?P<start>\d+(?:[_.,]\d+)?)")
_TEXT_SAMPLE = re.compile(rf"\s*{_QUANTITY}\s*:\s*([^;]+)")


@dataclass(frozen=True)
class SpectralChannels:
    """Names of channels by wavelength in nm, and what else there is."""

    emissive: Mapping[float, str] = field(default_factory=dict)
    reflective: Mapping[float, str] = field(default_factory=dict)
    polarised: bool = False
    bispectral: bool = False


def channel_name(wavelength_nm: float, component: str = "S0") -> str:
    """Name of the channel of a wavelength: emissive (S0) or reflective (T).

    Examples
    --------
    >>> channel_name(550), channel_name(412.5, "T")
    ('S0.550,000000nm', 'T.412,500000nm')
    """
    return f"{component}.{f'{wavelength_nm:.6f}'.replace('.', ',')}nm"


def find_channels(names: Iterable[str], file_name: str) -> SpectralChannels:
    """The spectral channels among the channels of a file.

    Parameters
    ----------
    names
        Names of all its channels; a layer's name may stand before those of the spectrum.
    file_name
        What the file is called in an error message.

    Raises
    ------
    FileFormatError
        If several layers hold spectra, or one wavelength has two channels.

    Examples
    --------
    >>> found = find_channels(["S0.400,0nm", "S0.0,5um", "S1.400,0nm", "R"], "a.exr")
    >>> dict(found.emissive), found.polarised
    ({400.0: 'S0.400,0nm', 500.0: 'S0.0,5um'}, True)

    Indigo names the lower edges of its buckets, with an underscore for the point:

    >>> dict(find_channels(["light.wavelength400", "light.wavelength430_25"], "b.exr").emissive)
    {415.125: 'light.wavelength400', 445.375: 'light.wavelength430_25'}
    """
    by_component: dict[str, dict[float, list[tuple[str, str]]]] = {}
    starts: dict[float, list[tuple[str, str]]] = {}
    bispectral = False
    for name in names:
        if match := _CHANNEL.fullmatch(name):
            wavelength_nm = _nanometres(*match.groups()[2:])
            if wavelength_nm > 0:
                entries = by_component.setdefault(match["component"], {})
                entries.setdefault(wavelength_nm, []).append((match["layer"] or "", name))
        elif match := _INDIGO.fullmatch(name):
            start_nm = float(re.sub("[_,]", ".", match["start"]))
            starts.setdefault(start_nm, []).append((match["layer"] or "", name))
        elif _BISPECTRAL.fullmatch(name):
            bispectral = True
    emissive = _unique(by_component.get("S0", {}), file_name)
    return SpectralChannels(
        emissive or _bucket_middles(_unique(starts, file_name), file_name),
        _unique(by_component.get("T", {}), file_name),
        polarised=any(f"S{number}" in by_component for number in (1, 2, 3)),
        bispectral=bispectral,
    )


def is_spectral(name: str) -> bool:
    """Whether a channel's name is one of a spectral image.

    Examples
    --------
    >>> is_spectral("T.550,0nm"), is_spectral("wavelength550"), is_spectral("T")
    (True, True, False)
    """
    return any(pattern.fullmatch(name) for pattern in (_CHANNEL, _BISPECTRAL, _INDIGO))


def _nanometres(number: str, multiplier: str | None, unit: str) -> float:
    """A wavelength, or the wavelength of a frequency, in nm, rounded to a femtometre.

    Examples
    --------
    >>> _nanometres("5,5E2", "n", "m"), _nanometres("0.55", "u", "m"), _nanometres("599.584916", "T", "Hz")
    (550.0, 550.0, 500.0)
    """
    value = float(number.replace(",", ".")) * _MULTIPLIERS[multiplier or ""]
    if value <= 0:
        return 0.0  # no light has it
    return round(value * 1e9 if unit == "m" else _LIGHT_SPEED_M_S / value * 1e9, 6)


def _unique(found: Mapping[float, list[tuple[str, str]]], file_name: str) -> dict[float, str]:
    """One channel for each wavelength; those outside all layers come before those of a layer."""
    layers = {layer for entries in found.values() for layer, _ in entries}
    if "" not in layers and len(layers) > 1:
        raise FileFormatError(
            f"{file_name} holds spectra in several layers ({', '.join(sorted(layers)[:4])}). Give a file with one."
        )
    wanted = "" if "" in layers else next(iter(layers), "")
    unique: dict[float, str] = {}
    for wavelength_nm, entries in found.items():
        names = [name for layer, name in entries if layer == wanted]
        if len(names) > 1:
            raise FileFormatError(
                f"{file_name} has the channels {' and '.join(names)} for {wavelength_nm:g} nm. Give each wavelength once."
            )
        if names:
            unique[wavelength_nm] = names[0]
    return unique


def _bucket_middles(starts: Mapping[float, str], file_name: str) -> dict[float, str]:
    """Channels by the middles of their buckets, of which the names are the lower edges; the last is as wide as the one before."""
    if not starts:
        return {}
    if len(starts) < 2:
        raise FileFormatError(f"{file_name} has one wavelength only. Give a spectral image with more.")
    edges = np.array(sorted(starts))
    widths = np.diff(edges)
    middles = edges + np.append(widths, widths[-1]) / 2
    return {float(middle): starts[float(edge)] for middle, edge in zip(middles, edges, strict=True)}


def spectrum_of_text(text: str) -> tuple[FloatArray, FloatArray]:
    """Wavelengths (N,) in nm, ascending, and values (N,) of a spectrum as it stands in a header.

    Raises
    ------
    FileFormatError
        If the text is no such spectrum.

    Examples
    --------
    >>> wavelengths_nm, values = spectrum_of_text("400.0nm:0.5;0.7um:1")
    >>> wavelengths_nm.tolist(), values.tolist()
    ([400.0, 700.0], [0.5, 1.0])
    """
    samples = []
    for part in text.strip().strip(";").split(";"):
        match = _TEXT_SAMPLE.fullmatch(part)
        try:
            number, multiplier, unit, value = match.groups() if match else ("", "", "", "")
            samples.append((_nanometres(number, multiplier, unit), float(value.replace(",", "."))))
        except ValueError:
            raise FileFormatError(
                f'"{part[:40]}" is no sample of a spectrum. Write it as 400nm:0.5;405nm:0.6 in the header.'
            ) from None
    table = np.array(sorted(samples))
    return table[:, 0], table[:, 1]


def text_of_spectrum(wavelengths_nm: FloatArray, values: FloatArray) -> str:
    """A spectrum as text for a header: the inverse of `spectrum_of_text`.

    Examples
    --------
    >>> text_of_spectrum(np.array([400.0, 405.5]), np.array([0.5, 1.0]))
    '400nm:0.5;405.5nm:1'
    """
    return ";".join(f"{nm:.10g}nm:{value:.9g}" for nm, value in zip(wavelengths_nm, values, strict=True))
