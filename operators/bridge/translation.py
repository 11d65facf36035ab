"""Colours of shader nodes made reflectances: the nodes and settings by which a copy of a material follows the wavelength.

Colours go from the working space to Rec.709, where what is out of gamut is clipped and named, and are uplifted by Mallett &
Yuksel (2019): at a wavelength a reflectance is one dot product, which a node group behind each linked colour computes.
"""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import bpy
import numpy as np
from mathutils import Color

from ...spectral_probe.spectra.emission import radiance_of_unit_luminance
from ...spectral_probe.spectra.grid import WAVELENGTHS_NM
from ...spectral_probe.spectra.uplift import reflectance_basis
from .restore import remove
from .shaders import link_of, set_value, unlink

type Array = np.ndarray[Any, Any]
type Setter = Callable[[Array], None]

GAMUT_NOTICE = 0.005
"""A colour clipped by less than this share of its largest channel is not worth a word."""

RGB_INDEX_NM = (611.0, 549.0, 464.0)
"""Dominant wavelengths of the Rec.709 primaries: where a refractive index given per channel is taken to hold."""

COEFFICIENTS = (
    "Radius",
    "Subsurface Radius",
    "Absorption Coefficient",
    "Absorption Coefficients",
    "Scatter Coefficients",
)
"""Vector inputs of shaders that hold one number for each of red, green and blue."""


def working_to_rec709() -> Array:
    """(3, 3) matrix from the file's working colour space to linear Rec.709."""
    return np.array([Color(unit).from_scene_linear_to_rec709_linear() for unit in np.eye(3)], float).T


def at(wavelengths_nm: Array, values: Array) -> Array:
    """Values (..., 61) of a table at wavelengths."""
    return np.interp(wavelengths_nm, WAVELENGTHS_NM, values)


@dataclass
class Translation:
    """What all materials and lamps of a render have in common while they are translated.

    `level` is the radiance per nm that is 1 in a pass. `setters` are called with the three wavelengths of a pass; `spectra`
    (n, 61) are the reflectances that occur; `stack` takes the temporary node groups away.
    """

    one_wavelength: bool
    level: float
    stack: ExitStack
    dispersive: bool = False
    setters: list[Setter] = field(default_factory=list)
    spectra: list[Array] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)

    @cached_property
    def rgb_level(self) -> float:
        """The Rec.709 value that is 1 in a light-basis pass, so that lamps and world layers of one luminance are alike."""
        return self.level / radiance_of_unit_luminance()

    @cached_property
    def to_rec709(self) -> Array:
        """Matrix from the working space."""
        return working_to_rec709()

    @cached_property
    def wide(self) -> bool:
        """Whether the working space is another than Rec.709, so that its colours may be out of gamut."""
        return not np.allclose(self.to_rec709, np.eye(3), atol=1e-4)

    def rec709(self, colour: Array, label: str, *, reflectance: bool) -> Array:
        """A colour (3,) of the working space in Rec.709, clipped to its gamut; what was clipped is named.

        A reflectance is also kept from exceeding one where none of its own channels did.
        """
        converted = self.to_rec709 @ np.asarray(colour, float) if self.wide else np.asarray(colour, float)
        clipped = np.maximum(converted, 0.0)
        if reflectance and self.wide:
            clipped = np.minimum(clipped, max(1.0, float(np.max(colour))))
        if self.wide:
            self.note_clipping(label, float(np.abs(converted - clipped).max()), float(np.max(np.abs(colour))))
        return clipped

    def note_clipping(self, label: str, amount: float, scale: float) -> None:
        """Name a colour outside the gamut of Rec.709, of which alone spectra are known."""
        if scale > 0 and amount > GAMUT_NOTICE * scale:
            self.warnings.append(
                f"{label} has a colour outside the gamut of Rec.709, which was clipped by {100 * amount / scale:.0f} %. "
                "Choose a less saturated colour, or a measured spectrum."
            )

    # ------------------------------------------------------------ sockets

    def bind_table(self, tree: bpy.types.NodeTree, socket: bpy.types.NodeSocket, values: Array) -> None:
        """Let a colour or vector socket follow a table (61,) over wavelength."""
        unlink(tree, socket)
        self.setters.append(lambda nm: set_value(socket, at(nm, values)))

    def bind_number(
        self, tree: bpy.types.NodeTree, socket: bpy.types.NodeSocket, values: Array, channel: int
    ) -> None:
        """Let a number follow a table (61,) at the wavelength of one channel."""
        unlink(tree, socket)

        def set_number(wavelengths_nm: Array) -> None:
            socket.default_value = float(at(wavelengths_nm[channel], values))

        self.setters.append(set_number)

    def bind_colour(
        self,
        label: str,
        tree: bpy.types.NodeTree,
        socket: bpy.types.NodeSocket,
        mask: Array | None = None,
    ) -> None:
        """Let a colour socket, constant or linked, follow the reflectance of its colour; `mask` (3,) picks channels."""
        link = link_of(socket)
        basis = reflectance_basis().T
        if link is None:
            spectrum = self.rec709(socket.default_value[:3], label, reflectance=True) @ basis
            if np.ptp(spectrum) > 1e-3 and socket.enabled:
                self.spectra.append(np.clip(spectrum, 0.0, 1.0)[None])
            unlink(tree, socket)
            picked = np.ones(3) if mask is None else mask
            self.setters.append(lambda nm: set_value(socket, at(nm, spectrum) * picked))
            return
        if socket.enabled:
            self.spectra.append(basis)
        for amount, scale in self._clipped_upstream(link):
            self.note_clipping(label, amount, scale)
        insert_group(tree, link, socket, self.reflectance_group)
        if mask is not None:
            reflectance = link_of(socket)
            tree.links.new(vector_math(tree, "MULTIPLY", reflectance.from_socket, tuple(mask)), socket)

    def bind_coefficients(self, tree: bpy.types.NodeTree, socket: bpy.types.NodeSocket) -> None:
        """Let a vector of one number for each of red, green and blue follow the wavelength.

        The numbers belong to bands, not to a colour: they are weighted as the bands of the Rec.709 primaries are.
        """
        link = link_of(socket)
        if link is None:
            self.bind_table(tree, socket, np.asarray(socket.default_value[:3], float) @ reflectance_basis().T)
        else:
            insert_group(tree, link, socket, self.band_group)

    def _clipped_upstream(self, link: bpy.types.NodeLink) -> Iterator[tuple[float, float]]:
        """How far constants that a linked colour is made of are out of gamut, and their largest channel."""
        if not self.wide:
            return
        for colour in colours_upstream(link):
            converted = self.to_rec709 @ colour
            yield float(np.abs(np.minimum(converted, 0.0)).max()), float(np.abs(colour).max())

    def bind_index(self, tree: bpy.types.NodeTree, socket: bpy.types.NodeSocket) -> None:
        """Let a refractive index of three channels follow the wavelength, by interpolation."""
        link = link_of(socket)
        if link is None:
            self.bind_table(tree, socket, index_rows(WAVELENGTHS_NM) @ np.array(socket.default_value[:3]))
        else:
            insert_group(tree, link, socket, self.index_group)

    # ------------------------------------------------------------ node groups

    @cached_property
    def reflectance_group(self) -> bpy.types.NodeTree:
        """Node group: a colour of the working space becomes its reflectance at the wavelengths of the pass."""
        return self._dots_group("Spectral Probe Reflectance", _reflectance_rows, clip=self.wide)

    @cached_property
    def band_group(self) -> bpy.types.NodeTree:
        """The same for numbers by band."""
        if not self.wide:
            return self.reflectance_group
        return self._dots_group("Spectral Probe Bands", _reflectance_rows, clip=False)

    @cached_property
    def index_group(self) -> bpy.types.NodeTree:
        """The same for a refractive index of three channels."""
        return self._dots_group("Spectral Probe Index", index_rows, clip=False)

    def _dots_group(self, name: str, rows_of: Callable[[Array], Array], *, clip: bool) -> bpy.types.NodeTree:
        group, source, target = new_group(name, self.stack)
        colour = in_rec709(group, source, self.to_rec709, bounded=True) if clip else source
        dots, output = dot_products(group, colour, 1 if self.one_wavelength else 3)
        group.links.new(output, target)

        def set_rows(wavelengths_nm: Array) -> None:
            for dot, row in zip(dots, rows_of(wavelengths_nm), strict=False):
                dot.inputs[1].default_value = row

        self.setters.append(set_rows)
        return group


def _reflectance_rows(wavelengths_nm: Array) -> Array:
    """(M, 3) reflectance of one unit of Rec.709 red, green and blue at wavelengths (M,)."""
    return np.stack([at(wavelengths_nm, primary) for primary in reflectance_basis().T], -1)


def index_rows(wavelengths_nm: Array) -> Array:
    """(M, 3) weights of red, green and blue by which a refractive index of three channels is interpolated."""
    red, green, blue = RGB_INDEX_NM
    return np.stack(
        [
            np.interp(wavelengths_nm, (green, red), (0.0, 1.0)),
            np.interp(wavelengths_nm, (blue, green, red), (0.0, 1.0, 0.0)),
            np.interp(wavelengths_nm, (blue, green), (1.0, 0.0)),
        ],
        -1,
    )


def new_group(name: str, stack: ExitStack) -> tuple[bpy.types.NodeTree, Any, Any]:
    """A temporary node group of one vector in, one out: (group, the socket inside that gives, the one that takes)."""
    group = bpy.data.node_groups.new(name, "ShaderNodeTree")
    stack.callback(remove, group)
    group.interface.new_socket("Value", in_out="INPUT", socket_type="NodeSocketVector")
    group.interface.new_socket("Value", in_out="OUTPUT", socket_type="NodeSocketVector")
    source, target = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    return group, source.outputs[0], target.inputs[0]


def vector_math(tree: bpy.types.NodeTree, operation: str, *operands: Any) -> bpy.types.NodeSocket:
    """A Vector Math node of sockets, or tuples for constants; its vector output."""
    node = tree.nodes.new("ShaderNodeVectorMath")
    node.operation = operation
    for socket, operand in zip(node.inputs, operands, strict=False):
        if isinstance(operand, bpy.types.NodeSocket):
            tree.links.new(operand, socket)
        else:
            socket.default_value = operand
    return node.outputs["Vector"]


def dot_products(
    tree: bpy.types.NodeTree, colour: bpy.types.NodeSocket, count: int
) -> tuple[list[bpy.types.Node], bpy.types.NodeSocket]:
    """Dot product nodes of a colour, and where their values come out: one number, or a vector of three."""
    dots = [tree.nodes.new("ShaderNodeVectorMath") for _ in range(count)]
    for dot in dots:
        dot.operation = "DOT_PRODUCT"
        tree.links.new(colour, dot.inputs[0])
    if count == 1:
        return dots, dots[0].outputs["Value"]
    joined = tree.nodes.new("ShaderNodeCombineXYZ")
    for dot, channel in zip(dots, joined.inputs, strict=True):
        tree.links.new(dot.outputs["Value"], channel)
    return dots, joined.outputs[0]


def in_rec709(
    tree: bpy.types.NodeTree, colour: bpy.types.NodeSocket, matrix: Array, *, bounded: bool
) -> bpy.types.NodeSocket:
    """Nodes from the working space to Rec.709 within its gamut, as `Translation.rec709` does for constants."""
    dots, converted = dot_products(tree, colour, 3)
    for dot, row in zip(dots, matrix, strict=True):
        dot.inputs[1].default_value = row
    clipped = vector_math(tree, "MAXIMUM", converted, (0.0, 0.0, 0.0))
    if not bounded:
        return clipped
    parts = tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(colour, parts.inputs[0])
    largest: Any = 1.0
    for channel in parts.outputs:
        node = tree.nodes.new("ShaderNodeMath")
        node.operation = "MAXIMUM"
        tree.links.new(channel, node.inputs[0])
        if isinstance(largest, float):
            node.inputs[1].default_value = largest
        else:
            tree.links.new(largest, node.inputs[1])
        largest = node.outputs[0]
    return vector_math(tree, "MINIMUM", clipped, largest)


def insert_group(
    tree: bpy.types.NodeTree,
    link: bpy.types.NodeLink,
    socket: bpy.types.NodeSocket,
    group: bpy.types.NodeTree,
) -> None:
    """Send what a link carries through a node group."""
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    tree.links.new(link.from_socket, node.inputs[0])
    tree.links.new(node.outputs[0], socket)


def colours_upstream(link: bpy.types.NodeLink) -> Iterator[Array]:
    """Colour constants in the nodes that a link's value is made of, within its tree: (3,) each, in the working space."""
    pending, seen = [link.from_node], {link.from_node}
    while pending:
        node = pending.pop()
        if node.type == "RGB":
            yield np.array(node.outputs[0].default_value[:3], float)
        if node.type == "VALTORGB":
            yield from (np.array(element.color[:3], float) for element in node.color_ramp.elements)
        for socket in node.inputs:
            feeding = link_of(socket)
            if feeding is None and socket.type == "RGBA" and socket.enabled:
                yield np.array(socket.default_value[:3], float)
            elif feeding is not None and feeding.from_node not in seen:
                seen.add(feeding.from_node)
                pending.append(feeding.from_node)
