"""The ordinary look of a spectral material or lamp: what the viewport and RGB renders show of it.

Only values of shaders change, as under D65. What is linked, a texture for example, stays; a shader is added where none fits the
kind, and nothing is deleted: the shader that fed the output stays in the tree.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import bpy
import numpy as np
from bpy.app.translations import pgettext_rpt as rpt_

from ...spectral_probe.spectra.colorimetry import spectra_to_xyz, xyz_to_rec709
from ...spectral_probe.spectra.edits import lamp_spectrum
from .emission import LUMINANCE
from .glass import FILTER_NODES, GLASS_NODES, PANE_INDEX, dispersive_index, pane_transmittance
from .rgb_twin import SODIUM_NM, in_working_space, metal_colours, under_d65
from .shaders import MEASURED_COLOUR, METAL_NODES, link_of, shaders
from .spectral_kinds import measured_reflectance
from .translation import at, working_to_rec709

type Array = np.ndarray[Any, Any]

WHITE = (1.0, 1.0, 1.0)
_OPAQUE = {"Metallic": 0.0, "Transmission Weight": 0.0, "Specular Tint": WHITE}
_CLEAR = {"Metallic": 0.0, "Transmission Weight": 1.0, "Specular Tint": WHITE}


def material_look(material: bpy.types.Material) -> tuple[str, ...]:
    """Set the look of a material to what its spectral settings say; what was left as it was, a sentence each."""
    if material.spectral_probe.kind not in _LOOKS or material.node_tree is None:
        return ()
    return _LOOKS[material.spectral_probe.kind](material)


def lamp_look(lamp: bpy.types.Light) -> tuple[str, ...]:
    """Give a lamp the colour of its measured spectrum, and as much power as keeps its luminance."""
    spectrum = lamp_spectrum(bpy.path.abspath(lamp.spectral_probe.lamp))
    rec709 = np.maximum(xyz_to_rec709(spectra_to_xyz(spectrum)), 0.0)
    colour = np.maximum(in_working_space(rec709 / rec709.max()), 0.0)
    before, after = _luminance(np.array(lamp.color[:])), _luminance(colour)
    lamp.color = tuple(map(float, colour))
    lamp.use_temperature = False
    if before > 0:
        lamp.energy *= before / after
    return ()


def _luminance(colour: Array) -> float:
    return float(LUMINANCE @ working_to_rec709() @ colour)


def _metal(material: bpy.types.Material) -> tuple[str, ...]:
    facing, tint = metal_colours(material.spectral_probe.metal)
    as_principled = {"Base Color": facing, "Specular Tint": tint, "Metallic": 1.0, "Transmission Weight": 0.0}
    by_type = {
        "BSDF_METALLIC": {"Base Color": facing, "Edge Tint": tint},
        "BSDF_GLOSSY": {"Color": facing},
        "BSDF_PRINCIPLED": as_principled,
    }
    nodes = _fitting(material, METAL_NODES, "ShaderNodeBsdfMetallic")
    for node in nodes:
        if node.type == "BSDF_METALLIC":
            node.fresnel_type = "F82"
    return _given(material, nodes, by_type, facing)


def _reflectance(material: bpy.types.Material) -> tuple[str, ...]:
    colour = np.clip(under_d65(measured_reflectance(material.spectral_probe.reflectance_path)), 0.0, 1.0)
    nodes = _fitting(material, tuple(MEASURED_COLOUR), "ShaderNodeBsdfDiffuse")
    by_type = {kind: {socket: colour} for kind, socket in MEASURED_COLOUR.items()}
    by_type["BSDF_PRINCIPLED"] |= _OPAQUE
    return _given(material, nodes, by_type, colour)


def _glass(material: bpy.types.Material) -> tuple[str, ...]:
    """A filter has the pane's colour; a body half of it at each of two surfaces, for want of absorption on the way."""
    settings = material.spectral_probe
    colour = np.clip(under_d65(pane_transmittance(settings.glass)), 0.0, 1.0)
    if settings.glass_as == "FILTER":
        nodes = _fitting(material, FILTER_NODES, "ShaderNodeBsdfTransparent")
        return _given(material, nodes, {kind: {"Color": colour} for kind in FILTER_NODES}, colour)
    through = {"Color": np.sqrt(colour), "IOR": PANE_INDEX}
    by_type = dict.fromkeys(FILTER_NODES, through)
    by_type["BSDF_PRINCIPLED"] = {"Base Color": np.sqrt(colour), "IOR": PANE_INDEX, **_CLEAR}
    nodes = _fitting(material, GLASS_NODES, "ShaderNodeBsdfGlass")
    return _given(material, nodes, by_type, colour)


def _dispersive(material: bpy.types.Material) -> tuple[str, ...]:
    index = float(at(np.array(SODIUM_NM), dispersive_index(material.spectral_probe)))
    clear = {"Color": np.array(WHITE), "IOR": index}
    by_type = dict.fromkeys(GLASS_NODES, clear)
    by_type["BSDF_PRINCIPLED"] = {"Base Color": np.array(WHITE), "IOR": index, **_CLEAR}
    nodes = _fitting(material, GLASS_NODES, "ShaderNodeBsdfGlass")
    return _given(material, nodes, by_type, np.array(WHITE))


_LOOKS: Mapping[str, Callable[[bpy.types.Material], tuple[str, ...]]] = {
    "METAL": _metal,
    "REFLECTANCE": _reflectance,
    "GLASS": _glass,
    "DISPERSIVE": _dispersive,
}


def _fitting(material: bpy.types.Material, kinds: tuple[str, ...], added: str) -> list[bpy.types.Node]:
    """The material's shaders of these kinds, those in groups left out; a new one at its output where there is none at all."""
    tree = material.node_tree
    found = [node for _, node in shaders([tree]) if node.type in kinds]
    if found:
        return found
    output = tree.get_output_node("CYCLES") or tree.nodes.new("ShaderNodeOutputMaterial")
    shader = tree.nodes.new(added)
    shader.location = (output.location.x - 300.0, output.location.y - 300.0)
    if "Roughness" in shader.inputs and added == "ShaderNodeBsdfGlass":
        shader.inputs["Roughness"].default_value = 0.0
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return [shader]


def _given(
    material: bpy.types.Material,
    nodes: list[bpy.types.Node],
    by_type: Mapping[str, Mapping[str, Any]],
    colour: Array,
) -> tuple[str, ...]:
    """Set the sockets of nodes that nothing is linked to, and the colour of the solid viewport."""
    left = []
    for node in nodes:
        for name, value in by_type[node.type].items():
            socket = node.inputs.get(name)
            if socket is None:
                continue
            if link_of(socket) is not None:
                left.append(
                    rpt_("{material}: {socket} is linked and was left as it is").format(
                        material=material.name, socket=name
                    )
                )
                continue
            socket.default_value = (*map(float, value), 1.0) if socket.type == "RGBA" else value
    material.diffuse_color = (*map(float, np.clip(colour, 0.0, 1.0)), 1.0)
    roughness = next(
        (node.inputs["Roughness"].default_value for node in nodes if "Roughness" in node.inputs), 0.5
    )
    material.metallic = 0.0  # the solid viewport has nothing for a metal to mirror
    material.roughness = float(roughness)
    return tuple(dict.fromkeys(left))
