"""Blender materials whose colours are reflectances: before each pass their R, G, B take three wavelengths."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np

from .spectra import BALL_FRACTIONS, WAVELENGTHS_NM, Array, metal_indices, reflectances


@dataclass
class SpectralMaterials:
    """The materials of one scene and the spectrum behind each of their sockets.

    Parameters
    ----------
    paints
        Reflectances (L,) by name.
    sockets
        Pairs of a node socket and the spectrum (L,) that it takes at a pass's wavelengths.
    """

    paints: dict[str, Array] = field(default_factory=reflectances)
    sockets: list[tuple[Any, Array]] = field(default_factory=list)
    known: dict[str, Any] = field(default_factory=dict)

    def set_wavelengths(self, wavelengths_nm: Array) -> None:
        """Put every spectrum at three wavelengths (3,) into its socket's R, G and B."""
        for socket, spectrum in self.sockets:
            values = np.interp(wavelengths_nm, WAVELENGTHS_NM, spectrum)
            socket.default_value = (*values, 1.0)[: len(socket.default_value)]

    def paint(self, name: str) -> Any:
        """A matt surface of one paint."""
        if name not in self.known:
            material, tree, output = _empty(name)
            shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
            self.sockets.append((shader.inputs["Color"], self.paints[name]))
            tree.links.new(shader.outputs["BSDF"], output.inputs["Surface"])
            self.known[name] = material
        return self.known[name]

    def boards(
        self, light: str, dark: str, board_m: tuple[float, float], roughness: float, *, upright: bool = False
    ) -> Any:
        """Boards between two woods under an achromatic varnish of index 1.5; `board_m` is their length and width."""
        name = f"{light} boards {board_m[0]:g} x {board_m[1]:g}"
        if name not in self.known:
            material, tree, output = _empty(name)
            mix = tree.nodes.new("ShaderNodeMix")
            mix.data_type = "RGBA"
            inputs = {socket.identifier: socket for socket in mix.inputs}
            outputs = {socket.identifier: socket for socket in mix.outputs}
            tree.links.new(_board_tones(tree, board_m, upright), inputs["Factor_Float"])
            self.sockets.extend(
                [(inputs["A_Color"], self.paints[light]), (inputs["B_Color"], self.paints[dark])]
            )
            shader = tree.nodes.new("ShaderNodeBsdfPrincipled")
            shader.inputs["Roughness"].default_value = roughness
            shader.inputs["IOR"].default_value = 1.5
            tree.links.new(outputs["Result_Color"], shader.inputs["Base Color"])
            tree.links.new(shader.outputs["BSDF"], output.inputs["Surface"])
            self.known[name] = material
        return self.known[name]

    def mirror_ball(self) -> Any:
        """SUS304: the smooth metals mixed by their fractions, which is eq. 11 exactly."""
        material, tree, output = _empty("SUS304")
        mixed, so_far = None, 0.0
        for metal, (n, k) in metal_indices().items():
            shader = tree.nodes.new("ShaderNodeBsdfMetallic")
            shader.fresnel_type = "PHYSICAL_CONDUCTOR"
            shader.distribution = "GGX"
            shader.inputs["Roughness"].default_value = 0.0
            self.sockets.extend([(shader.inputs["IOR"], n), (shader.inputs["Extinction"], k)])
            so_far += BALL_FRACTIONS[metal]
            if mixed is None:
                mixed = shader.outputs["BSDF"]
                continue
            mix = tree.nodes.new("ShaderNodeMixShader")
            mix.inputs["Factor"].default_value = BALL_FRACTIONS[metal] / so_far
            tree.links.new(mixed, mix.inputs[1])
            tree.links.new(shader.outputs["BSDF"], mix.inputs[2])
            mixed = mix.outputs["Shader"]
        tree.links.new(mixed, output.inputs["Surface"])
        return material


def emitter(name: str, strength: float = 1.0, clouds: bool = False) -> Any:
    """A one-sided surface that sends out its layer's spectrum times `strength`; `clouds` varies it softly over a window."""
    material, tree, output = _empty(name)
    shader = tree.nodes.new("ShaderNodeEmission")
    shader.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    shader.inputs["Strength"].default_value = strength
    if clouds:
        tree.links.new(_clouds(tree), shader.inputs["Strength"])
    tree.links.new(shader.outputs["Emission"], output.inputs["Surface"])
    material.cycles.emission_sampling = "FRONT"
    return material


def _clouds(tree: Any) -> Any:
    """0.72 to 1.0: brighter towards the top of the windows, soft clouds over it."""
    geometry = tree.nodes.new("ShaderNodeNewGeometry")
    stretch = tree.nodes.new("ShaderNodeMapping")
    stretch.inputs["Scale"].default_value = (0.22, 1.0, 0.45)
    tree.links.new(geometry.outputs["Position"], stretch.inputs["Vector"])
    noise = tree.nodes.new("ShaderNodeTexNoise")
    noise.inputs["Scale"].default_value = 1.0
    noise.inputs["Detail"].default_value = 2.0
    tree.links.new(stretch.outputs["Vector"], noise.inputs["Vector"])
    split = tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(geometry.outputs["Position"], split.inputs["Vector"])
    height = tree.nodes.new("ShaderNodeMapRange")
    for socket, value in zip(
        ("From Min", "From Max", "To Min", "To Max"), (3.0, 7.0, 0.70, 0.88), strict=True
    ):
        height.inputs[socket].default_value = value
    tree.links.new(split.outputs["Z"], height.inputs["Value"])
    cloud = tree.nodes.new("ShaderNodeMapRange")
    for socket, value in zip(
        ("From Min", "From Max", "To Min", "To Max"), (0.3, 0.7, 0.0, 0.12), strict=True
    ):
        cloud.inputs[socket].default_value = value
    tree.links.new(noise.outputs["Factor"], cloud.inputs["Value"])
    total = tree.nodes.new("ShaderNodeMath")
    total.operation = "ADD"
    tree.links.new(height.outputs["Result"], total.inputs[0])
    tree.links.new(cloud.outputs["Result"], total.inputs[1])
    return total.outputs["Value"]


def _board_tones(tree: Any, board_m: tuple[float, float], upright: bool) -> Any:
    """0..1 over the boards: each its own tone, with grain along it. They run along x, or up where they stand on a wall."""
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    along = tree.nodes.new("ShaderNodeMapping")
    along.inputs["Rotation"].default_value = (np.pi / 2, 0.0, np.pi / 2) if upright else (0.0, 0.0, 0.0)
    tree.links.new(coordinates.outputs["Object"], along.inputs["Vector"])
    bricks = tree.nodes.new("ShaderNodeTexBrick")
    bricks.offset = 0.37
    bricks.inputs["Color1"].default_value = (0.0, 0.0, 0.0, 1.0)
    bricks.inputs["Color2"].default_value = (0.8, 0.8, 0.8, 1.0)
    bricks.inputs["Mortar"].default_value = (1.0, 1.0, 1.0, 1.0)
    bricks.inputs["Scale"].default_value = 1.0
    bricks.inputs["Mortar Size"].default_value = 0.004
    bricks.inputs["Brick Width"].default_value = board_m[0]
    bricks.inputs["Row Height"].default_value = board_m[1]
    tree.links.new(along.outputs["Vector"], bricks.inputs["Vector"])
    stretch = tree.nodes.new("ShaderNodeMapping")
    stretch.inputs["Scale"].default_value = (0.8, 14.0, 14.0)
    tree.links.new(along.outputs["Vector"], stretch.inputs["Vector"])
    grain = tree.nodes.new("ShaderNodeTexNoise")
    grain.inputs["Scale"].default_value = 1.0
    tree.links.new(stretch.outputs["Vector"], grain.inputs["Vector"])
    both = tree.nodes.new("ShaderNodeMath")
    both.operation = "MULTIPLY_ADD"
    both.use_clamp = True
    tree.links.new(grain.outputs["Factor"], both.inputs[0])
    both.inputs[1].default_value = 0.35
    tree.links.new(bricks.outputs["Color"], both.inputs[2])
    return both.outputs["Value"]


def _empty(name: str) -> tuple[Any, Any, Any]:
    """Make a material; return it, its node tree and its output node, the only one."""
    material = bpy.data.materials.new(name)
    tree = material.node_tree
    tree.nodes.clear()
    return material, tree, tree.nodes.new("ShaderNodeOutputMaterial")
