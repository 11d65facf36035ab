"""What a material or a lamp becomes when an entry of the library is chosen for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import bpy

FIELDS: Mapping[str, str] = {
    "METAL": "metal",
    "REFLECTANCE": "reflectance_path",
    "GLASS": "glass",
    "DISPERSIVE": "clear_material",
    "LAMP": "lamp",
}
"""The setting that holds the entry's name, by kind."""


def entry_of(settings: bpy.types.PropertyGroup, kind: str) -> str:
    """The entry of a kind that a material's or a lamp's settings name."""
    return str(getattr(settings, FIELDS[kind])) if kind in FIELDS else ""


def check_entry(kind: str, entry: str) -> None:
    """Raise a `SpectralProbeError` that suggests the nearest where the library has no such entry, nor is there such a file."""
    from ...spectral_probe.spectra.dispersion import page_index
    from ...spectral_probe.spectra.edits import lamp_spectrum
    from .glass import pane_transmittance
    from .spectral_kinds import measured_reflectance, metal_index

    read: Mapping[str, Callable[[str], Any]] = {
        "METAL": metal_index,
        "REFLECTANCE": measured_reflectance,
        "GLASS": pane_transmittance,
        "DISPERSIVE": page_index,
        "LAMP": lambda name: lamp_spectrum(bpy.path.abspath(name)),
    }
    read[kind](entry)


def choose(
    owner: bpy.types.Material | bpy.types.Light, kind: str, entry: str, *, look: bool
) -> tuple[str, ...]:
    """Make a material or a lamp an entry of the library.

    Parameters
    ----------
    owner
        The material or the lamp; of a lamp, `kind` is "LAMP".
    kind, entry
        A kind of `FIELDS`, and a name of the library of that kind.
    look
        Also give it the colours that it has under D65, for the viewport and RGB renders.

    Returns
    -------
    tuple of str
        What of the look was left as it was, a sentence each.
    """
    from .look import lamp_look, material_look

    settings = owner.spectral_probe
    if kind == "LAMP":
        settings.light = "LAMP"
    else:
        settings.kind = kind
    setattr(settings, FIELDS[kind], entry)
    if kind == "DISPERSIVE":
        settings.index_from = "PAGE"
    if not look:
        return ()
    if kind == "LAMP":
        return lamp_look(owner) if isinstance(owner, bpy.types.Light) else ()
    return material_look(owner)
