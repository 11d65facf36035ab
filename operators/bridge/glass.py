"""Glass with a measured transmittance, as a thin filter or as a body that absorbs, and glass that disperses light."""

from typing import Any

import bpy
import numpy as np

from ...spectral_probe.errors import RenderError
from ...spectral_probe.spectra.dispersion import (
    cauchy_index,
    internal_transmittance,
    page_index,
    sellmeier_index,
)
from ...spectral_probe.spectra.glass import glass_transmittance
from .shaders import link_of, move_links, shaders, take, unlink
from .translation import Translation

type Array = np.ndarray[Any, Any]

FILTER_NODES = ("BSDF_TRANSPARENT", "BSDF_GLASS", "BSDF_REFRACTION", "BSDF_TRANSLUCENT")
GLASS_NODES = ("BSDF_GLASS", "BSDF_REFRACTION", "BSDF_PRINCIPLED")

PANE_INDEX = 1.52
"""Refractive index of the panes whose transmittance is measured with their surfaces: that of soda-lime glass."""

_DARKEST = 1e-4
"""Transmittances below this are within the stray light of spectrophotometers; their logarithm would mean nothing."""


def pane_transmittance(text: str) -> Array:
    """Transmittance (61,) of a glass of the library by name, or from a file."""
    if not text:
        raise RenderError(
            "no glass is given. Choose a glass of the library or a file with its transmittance."
        )
    return glass_transmittance(bpy.path.abspath(text))


def body_absorption(settings: Any) -> Array:
    """Absorption coefficient (61,) per unit of length inside a body of the glass, by Beer and Lambert."""
    transmittance = pane_transmittance(settings.glass)
    if settings.glass_with_surfaces:
        transmittance = internal_transmittance(transmittance, np.array(PANE_INDEX))
    return np.asarray(-np.log(np.maximum(transmittance, _DARKEST)) / settings.glass_thickness)


def dispersive_index(settings: Any) -> Array:
    """Refractive index (61,) of a material's dispersive glass."""
    match settings.index_from:
        case "CAUCHY":
            return cauchy_index(settings.cauchy)
        case "SELLMEIER":
            return sellmeier_index(settings.sellmeier_b, settings.sellmeier_c)
        case _:
            return page_index(settings.clear_material)


def filter_sockets(trees: list[bpy.types.NodeTree]) -> list[tuple[Any, Any]]:
    """The colours that a filter's transmittance takes the place of, as (tree, socket)."""
    found = [(tree, node.inputs["Color"]) for tree, node in shaders(trees) if node.type in FILTER_NODES]
    if not found:
        raise RenderError(
            "it is a glass filter, but has no Transparent, Glass or Refraction shader. Add one."
        )
    return found


def body_surfaces(trees: list[bpy.types.NodeTree]) -> list[tuple[Any, Any]]:
    """The colours of a glass body's surfaces, which become white, as (tree, socket)."""
    names = dict.fromkeys(FILTER_NODES, "Color") | {"BSDF_PRINCIPLED": "Base Color"}
    found = [(tree, node.inputs[names[node.type]]) for tree, node in shaders(trees) if node.type in names]
    if not found:
        raise RenderError(
            "it is a body of glass, but has no Glass, Refraction or Principled shader. Add one."
        )
    for tree, socket in found:
        unlink(tree, socket)
        socket.default_value = (1.0, 1.0, 1.0, 1.0)
    return found


def absorbing_socket(root: bpy.types.NodeTree) -> bpy.types.NodeSocket:
    """Absorption coefficients of a volume added to a material's output; what volume it had stays, too."""
    output = root.get_output_node("CYCLES")
    volume = root.nodes.new("ShaderNodeVolumeCoefficients")
    for name in ("Scatter Coefficients", "Emission Coefficients"):
        volume.inputs[name].default_value = (0.0, 0.0, 0.0)
    feeding = link_of(output.inputs["Volume"])
    if feeding is None:
        root.links.new(volume.outputs[0], output.inputs["Volume"])
    else:
        root.links.new(_sum(root, feeding.from_socket, volume.outputs[0]), output.inputs["Volume"])
    socket: bpy.types.NodeSocket = volume.inputs["Absorption Coefficients"]
    return socket


def translate_glass(translation: Translation, settings: Any, trees: list[bpy.types.NodeTree]) -> set[Any]:
    """Give a copy the measured transmittance; the sockets that are done."""
    if settings.glass_as == "FILTER":
        transmittance = pane_transmittance(settings.glass)
        translation.spectra.append(transmittance[None])
        sockets = filter_sockets(trees)
        for tree, socket in sockets:
            translation.bind_table(tree, socket, transmittance)
        return {socket for _, socket in sockets}
    absorption = body_absorption(settings)
    translation.spectra.append(np.exp(-np.outer((0.5, 1.0, 2.0), absorption) * settings.glass_thickness))
    done = {socket for _, socket in body_surfaces(trees)}
    socket = absorbing_socket(trees[0])
    translation.bind_table(trees[0], socket, absorption)
    return done | {socket}


def translate_dispersive(
    translation: Translation, settings: Any, label: str, trees: list[bpy.types.NodeTree]
) -> set[Any]:
    """Let a copy's refractive index follow the wavelength; the nodes that are done.

    Where the channels of a pass are three wavelengths, a shader becomes the sum of three, each with one channel's colour.
    """
    n = dispersive_index(settings)
    translation.dispersive = True
    done: set[Any] = set()
    for tree, node in glass_nodes(trees):
        if translation.one_wavelength:
            translation.bind_number(tree, node.inputs["IOR"], n, channel=0)
            continue
        total: Any = None
        for channel in range(3):
            one = _copied(tree, node)
            translation.bind_number(tree, one.inputs["IOR"], n, channel)
            translation.bind_colour(label, tree, one.inputs["Color"], mask=np.eye(3)[channel])
            done.add(one)
            total = one.outputs[0] if total is None else _sum(tree, total, one.outputs[0])
        move_links(tree, node, total)
        done.add(node)
    return done


def glass_nodes(trees: list[bpy.types.NodeTree]) -> list[tuple[Any, Any]]:
    """The Glass and Refraction nodes of a dispersive glass, as (tree, node); Principled ones become Glass."""
    found = [(tree, node) for tree, node in shaders(trees) if node.type in GLASS_NODES]
    if not found:
        raise RenderError(
            "it is a dispersive glass, but has no Glass or Refraction shader. Add a Glass BSDF."
        )
    return [(tree, _as_glass(tree, node)) for tree, node in found]


def _as_glass(tree: bpy.types.NodeTree, node: bpy.types.Node) -> bpy.types.Node:
    """The Glass node that takes the place of a Principled one that only transmits."""
    if node.type != "BSDF_PRINCIPLED":
        return node
    weight = node.inputs["Transmission Weight"]
    if link_of(weight) or weight.default_value < 1.0:
        raise RenderError(
            "it is a dispersive glass, but its Principled shader does not only transmit. Set its Transmission Weight to 1, or "
            "mix a Glass BSDF."
        )
    glass = tree.nodes.new("ShaderNodeBsdfGlass")
    glass.distribution = node.distribution
    for source, target in (("Base Color", "Color"), ("Roughness", "Roughness"), ("Normal", "Normal")):
        take(tree, node.inputs[source], glass.inputs[target])
    move_links(tree, node, glass.outputs[0])
    return glass


def _copied(tree: bpy.types.NodeTree, node: bpy.types.Node) -> bpy.types.Node:
    one = tree.nodes.new(node.bl_idname)
    one.distribution = node.distribution
    for source, target in zip(node.inputs, one.inputs, strict=True):
        take(tree, source, target)
    return one


def _sum(tree: bpy.types.NodeTree, one: Any, other: Any) -> bpy.types.NodeSocket:
    both = tree.nodes.new("ShaderNodeAddShader")
    tree.links.new(one, both.inputs[0])
    tree.links.new(other, both.inputs[1])
    output: bpy.types.NodeSocket = both.outputs[0]
    return output
