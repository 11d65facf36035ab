"""The RGB twin: the scene's materials and lamps as an artist would make them for plain RGB rendering.

A metal is the Metallic BSDF's F82 model with the base colour and the edge tint that the metal shows under D65, a measured
reflectance or transmittance its colour under D65, a dispersive glass has its index at the sodium line, and a measured lamp the
Rec.709 colour of its spectrum at the same luminance; other colours, lamps and emission stay as they are.
"""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

import bpy
import numpy as np

from ...spectral_probe.spectra.colorimetry import illuminant, spectra_to_xyz, xyz_to_rec709
from ...spectral_probe.spectra.metals import fresnel_reflectance
from .emission import LUMINANCE, Source, chosen_lamp, sources_of
from .glass import (
    absorbing_socket,
    body_absorption,
    body_surfaces,
    dispersive_index,
    filter_sockets,
    glass_nodes,
    pane_transmittance,
)
from .shaders import link_of, measured_sockets, metal_nodes, set_value, unlink
from .spectral_kinds import measured_reflectance, metal_index
from .stand_ins import Copy, lamp_copies, material_copies, naming
from .translation import Translation, at, dot_products, vector_math, working_to_rec709

SODIUM_NM = 589.3
"""Wavelength at which a glass's refractive index is usually given, and what an artist types."""

type Array = np.ndarray[Any, Any]


@contextmanager
def rgb_materials(scene: bpy.types.Scene) -> Iterator[None]:
    """Stand-ins for the materials and lamps of the scene while the block runs, for its RGB twin."""
    with ExitStack() as stack, material_copies(scene) as materials, lamp_copies(scene) as lamps:
        translation = Translation(one_wavelength=True, level=1.0, stack=stack)
        for copy in (*materials, *lamps):
            with naming(copy.label):
                if copy.kind == "Material":
                    _ordinary(copy)
                if chosen_lamp(copy):
                    for source in sources_of(copy, translation):
                        _as_colour(translation, source)
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
    match settings.kind:
        case "METAL":
            _f82_metal(settings.metal, copy.trees)
        case "REFLECTANCE":
            colour = under_d65(measured_reflectance(settings.reflectance_path))
            for tree, socket in measured_sockets(copy.trees):
                _set(tree, socket, np.maximum(colour, 0.0))
        case "GLASS":
            _coloured_glass(settings, copy.trees)
        case "DISPERSIVE":
            index = float(at(np.array(SODIUM_NM), dispersive_index(settings)))
            for tree, node in glass_nodes(copy.trees):
                unlink(tree, node.inputs["IOR"])
                node.inputs["IOR"].default_value = index


def _set(tree: bpy.types.NodeTree, socket: bpy.types.NodeSocket, colour: Array) -> None:
    """Give a socket a colour (3,) in place of its link."""
    unlink(tree, socket)
    set_value(socket, colour)


def _f82_metal(metal: str, trees: list[bpy.types.NodeTree]) -> None:
    """A metal as the F82 model's two colours."""
    facing, tint = metal_colours(metal)
    for tree, node in metal_nodes(trees):
        node.fresnel_type = "F82"
        _set(tree, node.inputs["Base Color"], facing)
        _set(tree, node.inputs["Edge Tint"], tint)


def _coloured_glass(settings: Any, trees: list[bpy.types.NodeTree]) -> None:
    """A pane of its colour under D65, or a body that absorbs by it."""
    if settings.glass_as == "FILTER":
        colour = np.maximum(under_d65(pane_transmittance(settings.glass)), 0.0)
        for tree, socket in filter_sockets(trees):
            _set(tree, socket, colour)
        return
    body_surfaces(trees)
    transmittance = np.exp(-body_absorption(settings) * settings.glass_thickness)
    colour = np.clip(under_d65(transmittance), 1e-4, 1.0)
    set_value(absorbing_socket(trees[0]), -np.log(colour) / settings.glass_thickness)


def _as_colour(translation: Translation, source: Source) -> None:
    """Give a measured lamp the colour of its spectrum at the luminance of the colour that it had."""
    if source.spectrum is None:
        return
    rec709 = np.maximum(xyz_to_rec709(spectra_to_xyz(source.spectrum)), 0.0)
    colour = in_working_space(rec709 / (rec709 @ LUMINANCE))
    weights = LUMINANCE @ translation.to_rec709 * source.filter
    link = link_of(source.colour)
    if link is None:
        set_value(
            source.colour, weights @ np.array(source.colour.default_value[:3]) * np.maximum(colour, 0.0)
        )
        return
    dots, luminance = dot_products(source.tree, link.from_socket, 1)
    dots[0].inputs[1].default_value = weights
    source.tree.links.new(vector_math(source.tree, "MULTIPLY", luminance, tuple(colour)), source.colour)
