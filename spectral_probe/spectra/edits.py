"""Edits of a spectral panorama: stained glass before a region, or another lamp in it. Nothing is lost.

Weights stay as they are. A region's texels get a new basis, derived from the one they had, and the panorama remembers from
which and how: to take an edit back, the bases that rest on it are derived anew from the recovered ones without it. Whatever is
restored is therefore the same to the bit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ..errors import SpectralDataError
from ..files.spectrum_csv import read_spectrum_csv
from ..model import BoolArray, Edit, FloatArray, Keeps, SpectralPanorama, Texels
from .colorimetry import colour_matching_functions
from .glass import glass_transmittance
from .grid import WAVELENGTHS_NM, resample
from .library import lamp_spectrum as lamp_by_name

MOST_BASES = 256
"""As many as the 8-bit `basis_index` can tell apart."""

_DARKEST = 1e-3
"""An old lamp must give this share of its peak at every wavelength, or what its surfaces reflect there is lost in noise."""

type Stack = tuple[int, ...]
"""A recovered basis and the edits done to it, as in `SpectralPanorama.derived_bases`; (b,) is the recovered basis b itself."""


def glass_edit(panorama: SpectralPanorama, glass: str | Path, region: str) -> Edit:
    """A stained glass by name or file (`glass.glass_transmittance`), for `apply_edit`."""
    return Edit("glass", _name(glass), region, _on_grid_of(panorama, glass_transmittance(glass)))


def lamp_edit(
    panorama: SpectralPanorama,
    lamp: str | Path,
    region: str,
    keeps: Keeps = "luminance",
    was: str | Path | None = None,
) -> Edit:
    """Another lamp, for `apply_edit`.

    Parameters
    ----------
    panorama
        The panorama to be edited.
    lamp
        The name of a light of the library, or the path of a table of wavelength in nm and power.
    region
        Where, in words.
    keeps
        What stays of the light in each direction: its luminance, or its radiant power over the panorama's wavelengths; or the
        colours of surfaces, whose light is multiplied by the new lamp over the old one, both of one luminance.
    was
        The old lamp, a name or a file; needed to keep surfaces.

    Raises
    ------
    SpectralDataError
        If there is no such light or file, or it has negative power or no visible light; or if the old lamp lacks light at
        some wavelength, where its surfaces then cannot be known.
    """
    spectrum, name = lamp_spectrum(lamp), _name(lamp)
    if keeps == "surfaces":
        if was is None:
            raise SpectralDataError(
                "Say which lamp it was: only then can the surfaces in its light be told from it."
            )
        spectrum, name = _over(spectrum, lamp_spectrum(was), _name(was)), f"{name} for {_name(was)}"
    return Edit("lamp", name, region, _on_grid_of(panorama, spectrum), keeps)


def _over(new: FloatArray, old: FloatArray, old_name: str) -> FloatArray:
    """The new lamp over the old one, both of one luminance, (61,)."""
    dark = old < _DARKEST * old.max()
    if dark.any():
        raise SpectralDataError(
            f"The lamp {old_name} gives no light at {WAVELENGTHS_NM[dark][0]:g} nm, so the surfaces in its light are not known "
            "there. Replace the lamp alone, keeping its luminance."
        )
    y_bar = colour_matching_functions()[:, 1]
    return new / old * (old @ y_bar / (new @ y_bar))


def lamp_spectrum(lamp: str | Path) -> FloatArray:
    """Relative spectral power (61,) of a light of the library by name, or of a user's file.

    Examples
    --------
    >>> lamp_spectrum("LED-B3").shape
    (61,)
    """
    path = Path(lamp).expanduser()
    spectrum = read_spectrum_csv(path)[0] if path.is_file() else _library_light(str(lamp))
    if spectrum.min() < 0:
        raise SpectralDataError(f"The lamp {_name(lamp)} has negative power. Give its spectrum as measured.")
    if not spectrum @ colour_matching_functions()[:, 1] > 0:
        raise SpectralDataError(f"The lamp {_name(lamp)} gives no light that is seen. Choose another.")
    return spectrum


def _library_light(name: str) -> FloatArray:
    if Path(name).suffix.lower() in {".csv", ".txt", ".spd", ".tsv", ".spdx"} or Path(name).name != name:
        raise SpectralDataError(f"There is no file {name}. Check the path, or name a light of the library.")
    return lamp_by_name(name)


def _name(thing: str | Path) -> str:
    path = Path(thing).expanduser()
    return path.name if path.is_file() else str(thing)


def _on_grid_of(panorama: SpectralPanorama, spectrum: FloatArray) -> FloatArray:
    if np.array_equal(panorama.wavelengths_nm, WAVELENGTHS_NM):
        return np.array(spectrum)
    return resample(WAVELENGTHS_NM, spectrum, panorama.wavelengths_nm, name="the spectrum of the edit")


# ---------------------------------------------------------------- making and taking back


def apply_edit(panorama: SpectralPanorama, edit: Edit, mask: BoolArray) -> SpectralPanorama:
    """A panorama with one more edit, the last of its `edits`.

    Parameters
    ----------
    panorama
        With any number of bases, weights and earlier edits.
    edit
        What to do. Over earlier edits it is done last: a lamp behind an earlier glass keeps the luminance that came through it.
    mask
        (H, W) the texels of its region.

    Returns
    -------
    SpectralPanorama
        The same weights, confidence and everything else; new bases for the region, and `basis_index` pointing to them.

    Raises
    ------
    SpectralDataError
        If the region is empty, or more than `MOST_BASES` would be needed.

    Examples
    --------
    >>> one, first = np.ones((1, 2), np.float32), np.zeros((1, 2), np.uint8)
    >>> basis = np.ones((1, 1, 61))
    >>> panorama = SpectralPanorama(one[..., None], basis, first, WAVELENGTHS_NM, one > 0, one)
    >>> half = Edit("glass", "grey", "left", np.full(61, 0.5))
    >>> edited = apply_edit(panorama, half, np.array([[True, False]]))
    >>> edited.basis_index.tolist(), edited.bases[:, 0, 0].tolist()
    ([[1, 0]], [1.0, 0.5])
    >>> remove_edit(edited, 0).bases.shape
    (1, 1, 61)
    """
    if not mask.any():
        raise SpectralDataError(f"The region ({edit.region}) selects nothing. Make it larger.")
    number = len(panorama.edits)

    def changed(stack: Stack) -> Stack:
        return (*stack, number)

    return _with_stacks(replace(panorama, edits=(*panorama.edits, edit)), stacks_of(panorama), changed, mask)


def remove_edit(panorama: SpectralPanorama, number: int) -> SpectralPanorama:
    """A panorama without one of its edits, counted from 0; what lay under it is restored to the bit.

    Raises
    ------
    SpectralDataError
        If there is no edit of that number.
    """
    if not 0 <= number < len(panorama.edits):
        kept = len(panorama.edits)
        told = f"it has {kept}, counted from 1" if kept else "it has none"
        raise SpectralDataError(f"The probe has no edit {number + 1}: {told}.")

    def changed(stack: Stack) -> Stack:
        return (stack[0], *(edit - (edit > number) for edit in stack[1:] if edit != number))

    edits = panorama.edits[:number] + panorama.edits[number + 1 :]
    everywhere = np.ones(panorama.valid.shape, bool)
    return _with_stacks(replace(panorama, edits=edits), stacks_of(panorama), changed, everywhere)


def remove_all_edits(panorama: SpectralPanorama) -> SpectralPanorama:
    """The panorama as it was recovered."""
    while panorama.edits:
        panorama = remove_edit(panorama, len(panorama.edits) - 1)
    return panorama


def _with_stacks(
    panorama: SpectralPanorama, stacks: Sequence[Stack], changed: Callable[[Stack], Stack], mask: BoolArray
) -> SpectralPanorama:
    """A panorama whose texels under a mask have changed stacks, with the bases that are then in use."""
    recovered = sum(len(stack) == 1 for stack in stacks)
    wanted: dict[Stack, int] = {stack: index for index, stack in enumerate(stacks[:recovered])}
    renumbered = np.zeros((2, len(stacks)), np.intp)  # of bases outside and inside the mask
    for side, how in enumerate((_unchanged, changed)):
        used = np.bincount(panorama.basis_index[mask == side], minlength=len(stacks)) > 0
        for number in np.flatnonzero(used).tolist():
            renumbered[side, number] = wanted.setdefault(how(stacks[number]), len(wanted))
    if len(wanted) > MOST_BASES:
        raise SpectralDataError(
            f"The edits overlap in {len(wanted)} different ways, and a probe holds {MOST_BASES}. Remove an edit first."
        )
    index = renumbered[mask.astype(np.intp), panorama.basis_index]
    derived = tuple(wanted)[recovered:]
    bases = [*panorama.bases[:recovered], *(_derived(panorama, stack) for stack in derived)]
    return replace(panorama, bases=np.stack(bases), basis_index=index.astype(np.uint8), derived_bases=derived)


def _unchanged(stack: Stack) -> Stack:
    return stack


def _derived(panorama: SpectralPanorama, stack: Stack) -> FloatArray:
    """Basis (K, L) of a stack: its recovered basis with its edits done to it in order."""
    basis: FloatArray = panorama.bases[stack[0]]
    for number in stack[1:]:
        basis = _edited(basis, panorama.edits[number], panorama.wavelengths_nm)
    return basis


def _edited(basis: FloatArray, edit: Edit, wavelengths_nm: FloatArray) -> FloatArray:
    """A basis (K, L) after an edit.

    Times the transmittance, or the lamps' ratio; or each function's luminance (or power) in the lamp's spectrum.

    Both are linear in the weights, and so never make a spectrum negative that was not: the luminance of light is not.
    """
    if edit.kind == "glass" or edit.keeps == "surfaces":
        return basis * edit.spectrum
    kept = np.ones(len(wavelengths_nm))
    if edit.keeps == "luminance":
        kept = np.interp(wavelengths_nm, WAVELENGTHS_NM, colour_matching_functions()[:, 1])
    return np.outer(basis @ kept, edit.spectrum / (edit.spectrum @ kept))


# ---------------------------------------------------------------- what the edits mean for others


def stacks_of(panorama: SpectralPanorama) -> tuple[Stack, ...]:
    """For each basis the recovered basis it came from and the edits done to it."""
    recovered = len(panorama.bases) - len(panorama.derived_bases)
    return (*((index,) for index in range(recovered)), *panorama.derived_bases)


def recovered_index(panorama: SpectralPanorama) -> npt.NDArray[np.uint8]:
    """Which recovered basis (H, W) each texel's weights were recovered with, whatever was done to it since."""
    return recovered_basis(panorama, panorama.basis_index)


def recovered_basis(panorama: SpectralPanorama, index: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """The recovered bases (...) that some bases (...) of a panorama came from, by number."""
    origin = np.array([stack[0] for stack in stacks_of(panorama)], np.uint8)
    return origin[index]


def is_edited(panorama: SpectralPanorama, number: int) -> BoolArray:
    """Which bases (B,) an edit, counted from 0, was done to."""
    return np.array([number in stack[1:] for stack in stacks_of(panorama)])


def edited_mask(panorama: SpectralPanorama, number: int) -> BoolArray:
    """Texels (H, W) that an edit, counted from 0, was done to."""
    return np.asarray(is_edited(panorama, number)[panorama.basis_index])


def edited_confidence(panorama: SpectralPanorama, chosen: Texels | None = None) -> FloatArray:
    """How sure the panorama's spectra are after its edits, (H, W) in 0..1; of some texels (N,) where they are given.

    `confidence` is of what was recovered, and no edit touches it. A glass multiplies the spectrum and its error alike. Where a
    lamp was replaced the spectrum is known: its confidence is 1, whatever the photographs said; not so that of surfaces.
    """
    replaced = [edit.kind == "lamp" and edit.keeps != "surfaces" for edit in panorama.edits]
    known = np.array([any(replaced[edit] for edit in stack[1:]) for stack in stacks_of(panorama)])
    where = ... if chosen is None else chosen
    return np.where(known[panorama.basis_index[where]], np.float32(1.0), panorama.confidence[where])
