"""The paper's surface (eq. 12) as a node group for Cycles: Torrance-Sparrow with alpha, beta, beta' and gamma.

The group adds a Diffuse BSDF of albedo pi alpha S, a Metallic BSDF of Beckmann facets and a smooth Metallic BSDF, so the
spectral passes translate it like any other: a material of kind METAL gives both Metallic nodes its refractive index, one of kind
REFLECTANCE the Diffuse node its measured reflectance. Everything follows from the group's inputs by math nodes.

- Facets: the Beckmann distribution of the paper's half width, alpha_B = tan gamma / sqrt(ln 2 - 4 ln cos gamma)
  (`render/beckmann.py`); Cycles' roughness is its root.
- Weight of the lobe: 4 pi alpha_B^2 beta, since Cycles' distribution of facets is normalised and the paper's D(0) is 1.

Cycles' shadowing is Smith's, the paper's that of V-grooves: the two differ at grazing angles (docs/paper.md).
"""

from __future__ import annotations

import math

import bpy

from ...spectral_probe.render.beckmann import WIDEST_GAMMA_RAD
from .materials import metal_colours

GROUP_NAME = "Torrance-Sparrow"
INPUTS = (
    "Diffuse Color",
    "Metal Color",
    "Metal Edge Tint",
    "Alpha",
    "Beta",
    "Beta Mirror",
    "Gamma",
    "Normal",
)
"""Inputs of the group by name."""

_OURS = "spectral_probe_torrance_sparrow"
"""Custom property that marks the group as made here, with its version."""

_VERSION = 1

_MOST_DOUBLINGS = 5
"""A shader can be added up to 2^5 times: the factor of a Mix Shader ends at 1, weights of eq. 12 do not."""

type Socket = bpy.types.NodeSocket


def torrance_sparrow_group() -> bpy.types.NodeTree:
    """The node group; one that is in the file already is used again."""
    for group in bpy.data.node_groups:
        if group.get(_OURS) == _VERSION:
            return group
    group = bpy.data.node_groups.new(GROUP_NAME, "ShaderNodeTree")
    group[_OURS] = _VERSION
    _interface(group)
    nodes = _Nodes(group)
    inputs = nodes.add("NodeGroupInput", 0).outputs
    alpha, beta, mirror, gamma = (inputs[name] for name in ("Alpha", "Beta", "Beta Mirror", "Gamma"))

    diffuse = nodes.add("ShaderNodeBsdfDiffuse", 4)
    nodes.link(inputs["Diffuse Color"], diffuse.inputs["Color"])
    cosine = nodes.math("COSINE", gamma)
    exponent = nodes.math("SUBTRACT", math.log(2.0), nodes.math("MULTIPLY", 4.0, _logarithm(nodes, cosine)))
    squared = nodes.math("DIVIDE", nodes.math("POWER", nodes.math("TANGENT", gamma), 2.0), exponent)
    facets = _metallic(nodes, inputs, "BECKMANN")
    nodes.link(nodes.math("POWER", squared, 0.25), facets.inputs["Roughness"])
    lobe_weight = nodes.math("MULTIPLY", nodes.math("MULTIPLY", 4.0 * math.pi, squared), beta)
    smooth = _metallic(nodes, inputs, "GGX")
    smooth.inputs["Roughness"].default_value = 0.0
    for shader in (diffuse, facets, smooth):
        nodes.link(inputs["Normal"], shader.inputs["Normal"])

    parts = [
        _weighted(nodes, diffuse.outputs[0], nodes.math("MULTIPLY", math.pi, alpha), 2),
        _weighted(nodes, facets.outputs[0], lobe_weight, _MOST_DOUBLINGS),
        _weighted(nodes, smooth.outputs[0], mirror, 2),
    ]
    surface = nodes.sum(nodes.sum(parts[0], parts[1]), parts[2])
    output = nodes.add("NodeGroupOutput", 9)
    nodes.link(surface, output.inputs[0])
    return group


def torrance_sparrow_material(
    name: str,
    *,
    metal: str = "Au",
    alpha: float = 0.0,
    beta: float = 4.0,
    beta_mirror: float = 0.0,
    gamma_rad: float = math.radians(8.0),
) -> bpy.types.Material:
    """A material of the node group, a metal in spectral renders and in its colours under D65 in ordinary ones.

    Parameters
    ----------
    name
        Of the material; Blender appends a number where it is taken.
    metal
        As in `metals.refractive_index`.
    alpha, beta, beta_mirror, gamma_rad
        Of eq. 12, as in `render.torrance_sparrow.TorranceSparrowSurface`.
    """
    facing, tint = metal_colours(metal)
    material = bpy.data.materials.new(name)
    material.spectral_probe.kind, material.spectral_probe.metal = "METAL", metal
    material.diffuse_color = (*facing, 1.0)
    tree = material.node_tree
    tree.nodes.clear()
    node, output = tree.nodes.new("ShaderNodeGroup"), tree.nodes.new("ShaderNodeOutputMaterial")
    node.node_tree, node.width, output.location = torrance_sparrow_group(), 200.0, (300.0, 0.0)
    node.label = GROUP_NAME
    values = {"Alpha": alpha, "Beta": beta, "Beta Mirror": beta_mirror, "Gamma": gamma_rad}
    colours = {"Metal Color": facing, "Metal Edge Tint": tint}
    for socket, value in values.items():
        node.inputs[socket].default_value = value
    for socket, colour in colours.items():
        node.inputs[socket].default_value = (*colour, 1.0)
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return material


def _interface(group: bpy.types.NodeTree) -> None:
    """The group's sockets, with tooltips, units and limits."""
    colours = {
        "Diffuse Color": ((0.5, 0.5, 0.5, 1.0), "Reflectance S of the diffuse part"),
        "Metal Color": ((1.0, 1.0, 1.0, 1.0), "What the metal reflects head on, in RGB renders"),
        "Metal Edge Tint": ((1.0, 1.0, 1.0, 1.0), "The metal's tint at grazing angles, in RGB renders"),
    }
    numbers = {
        "Alpha": (0.0, 4.0 / math.pi, "Weight of diffuse reflection per steradian; 0.318 reflects all of S"),
        "Beta": (4.0, 1000.0, "Height of the specular lobe per steradian"),
        "Beta Mirror": (0.0, 4.0, "Weight beta' of perfect mirror reflection"),
        "Gamma": (
            math.radians(8.0),
            WIDEST_GAMMA_RAD,
            "Angle of a facet to the surface at which the lobe halves",
        ),
    }
    new = group.interface.new_socket
    new("Surface", in_out="OUTPUT", socket_type="NodeSocketShader")
    for name, (default, description) in colours.items():
        socket = new(name, in_out="INPUT", socket_type="NodeSocketColor", description=description)
        socket.default_value = default
    for name, (default, most, description) in numbers.items():
        socket = new(name, in_out="INPUT", socket_type="NodeSocketFloat", description=description)
        if name == "Gamma":
            socket.subtype = "ANGLE"
        socket.min_value, socket.max_value, socket.default_value = 0.0, most, default
    normal = new(
        "Normal", in_out="INPUT", socket_type="NodeSocketVector", description="Normal of the surface"
    )
    normal.hide_value = True


class _Nodes:
    """Adds nodes to a tree, in columns from left to right."""

    def __init__(self, tree: bpy.types.NodeTree) -> None:
        self.tree = tree
        self.filled: dict[int, int] = {}

    def add(self, kind: str, column: int) -> bpy.types.Node:
        node = self.tree.nodes.new(kind)
        row = self.filled.get(column, 0)
        self.filled[column] = row + 1
        node.location = (column * 190.0, -row * 230.0)
        return node

    def link(self, source: Socket, target: Socket) -> None:
        self.tree.links.new(source, target)

    def math(self, operation: str, *values: Socket | float) -> Socket:
        """The output of a Math node of sockets and constants."""
        node = self.add("ShaderNodeMath", 2)
        node.operation = operation
        for value, target in zip(values, node.inputs, strict=False):
            if isinstance(value, bpy.types.NodeSocket):
                self.link(value, target)
            else:
                target.default_value = value
        return node.outputs[0]

    def sum(self, first: Socket, second: Socket) -> Socket:
        """The output of an Add Shader node."""
        node = self.add("ShaderNodeAddShader", 7)
        self.link(first, node.inputs[0])
        self.link(second, node.inputs[1])
        return node.outputs[0]


def _logarithm(nodes: _Nodes, value: Socket) -> Socket:
    return nodes.math("LOGARITHM", value, math.e)


def _metallic(nodes: _Nodes, inputs: bpy.types.NodeOutputs, distribution: str) -> bpy.types.Node:
    """A Metallic BSDF in the group's colours."""
    node = nodes.add("ShaderNodeBsdfMetallic", 4)
    node.distribution, node.fresnel_type = distribution, "F82"
    nodes.link(inputs["Metal Color"], node.inputs["Base Color"])
    nodes.link(inputs["Metal Edge Tint"], node.inputs["Edge Tint"])
    return node


def _weighted(nodes: _Nodes, shader: Socket, weight: Socket, doublings: int) -> Socket:
    """A shader times a weight up to 2^doublings: mixed with nothing, then added to itself.

    Cycles adds up the weights of a shader that is reached twice, so this stays one closure.
    """
    mix = nodes.add("ShaderNodeMixShader", 6)  # its first shader stays empty: black
    nodes.link(nodes.math("DIVIDE", weight, 2.0**doublings), mix.inputs[0])
    nodes.link(shader, mix.inputs[2])
    weighted = mix.outputs[0]
    for _ in range(doublings):
        weighted = nodes.sum(weighted, weighted)
    return weighted
