"""The RGB twin: the scene's materials and lamps as an artist would make them for plain RGB rendering.

A metal is the Metallic BSDF's F82 model with the base colour and the edge tint that the metal shows under D65, a measured
reflectance its colour under D65; other colours, lamps and emission stay as they are.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import bpy
import numpy as np

from ...spectral_probe.spectra.colorimetry import illuminant, spectra_to_xyz, xyz_to_rec709
from ...spectral_probe.spectra.metals import fresnel_reflectance
from .shaders import measured_sockets, metal_nodes, set_value, unlink
from .spectral_kinds import measured_reflectance, metal_index
from .stand_ins import Copy, material_copies, naming
from .translation import working_to_rec709

type Array = np.ndarray[Any, Any]


@contextmanager
def rgb_materials(scene: bpy.types.Scene) -> Iterator[None]:
    """Stand-ins for the materials of the scene while the block runs, for its RGB twin."""
    with material_copies(scene) as copies:
        for copy in copies:
            with naming(copy.label):
                _ordinary(copy)
        yield


def under_d65(reflectance: Array) -> Array:
    """Colour (..., 3) of reflectances (..., 61) under D65 in the working space, white being 1."""
    light = illuminant("D65")
    xyz = spectra_to_xyz(reflectance * light) / spectra_to_xyz(light)[1]
    return in_working_space(xyz_to_rec709(xyz))


def in_working_space(rec709: Array) -> Array:
    """Linear Rec.709 (..., 3) in the file's working space."""
    return rec709 @ np.linalg.inv(working_to_rec709()).T


def metal_colours(metal: str) -> tuple[Array, Array]:
    """Base colour and edge tint (3,) of a metal for the Metallic BSDF's F82 model, in the working space, under D65.

    The F82 model (Kutz, Hasan & Edmondson 2021) is Schlick's approximation times the tint at cos = 1/7.
    """
    n, k = metal_index(metal)
    facing, edge = (under_d65(fresnel_reflectance(n, k, np.array(cosine))) for cosine in (1.0, 1.0 / 7.0))
    schlick = facing + (1.0 - facing) * (6.0 / 7.0) ** 5
    return np.clip(facing, 0.0, 1.0), np.clip(edge / schlick, 0.0, 1.0)


def _ordinary(copy: Copy) -> None:
    """Make a material's copy the RGB twin of its spectral one."""
    settings = getattr(copy.datablock, "spectral_probe", None)
    if settings is None or not copy.trees:
        return
    if settings.kind == "METAL":
        facing, tint = metal_colours(settings.metal)
        for tree, node in metal_nodes(copy.trees):
            node.fresnel_type = "F82"
            for socket, colour in ((node.inputs["Base Color"], facing), (node.inputs["Edge Tint"], tint)):
                unlink(tree, socket)
                set_value(socket, colour)
    elif settings.kind == "REFLECTANCE":
        colour = np.maximum(under_d65(measured_reflectance(settings.reflectance_path)), 0.0)
        for tree, socket in measured_sockets(copy.trees):
            unlink(tree, socket)
            set_value(socket, colour)
