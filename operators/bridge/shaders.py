"""Work on the node trees of temporary materials: finding shaders, replacing them, setting their sockets."""

from contextlib import ExitStack
from typing import Any

import bpy
import numpy as np

from ...spectral_probe.errors import RenderError
from .restore import remove

type Array = np.ndarray[Any, Any]

METAL_NODES = ("BSDF_METALLIC", "BSDF_GLOSSY", "BSDF_PRINCIPLED")
MEASURED_COLOUR = {
    "BSDF_DIFFUSE": "Color",
    "BSDF_PRINCIPLED": "Base Color",
    "SUBSURFACE_SCATTERING": "Color",
    "BSDF_TRANSLUCENT": "Color",
}


def own_trees(root: bpy.types.NodeTree, stack: ExitStack) -> list[bpy.types.NodeTree]:
    """The tree and all groups in it, groups replaced by copies that go with the stack."""
    own: dict[bpy.types.NodeTree, bpy.types.NodeTree] = {}
    trees = [root]
    for tree in trees:  # grows while it is walked
        tree.animation_data_clear()
        for node in tree.nodes:
            group = node.node_tree if node.type == "GROUP" else None
            if group is None:
                continue
            if group not in own:
                own[group] = group.copy()
                stack.callback(remove, own[group])
                trees.append(own[group])
            node.node_tree = own[group]
    return trees


def shaders(trees: list[bpy.types.NodeTree]) -> list[tuple[bpy.types.NodeTree, bpy.types.Node]]:
    """All nodes that make a shader and lead to an output of their tree, as (tree, node)."""
    return [
        (tree, node)
        for tree in trees
        for node in leading_to_output(tree)
        if node.type not in {"GROUP", "GROUP_INPUT", "REROUTE"}
        and any(o.type == "SHADER" for o in node.outputs)
    ]


def leading_to_output(tree: bpy.types.NodeTree) -> list[bpy.types.Node]:
    """The nodes that an output of the tree depends on, the outputs among them."""
    found = [node for node in tree.nodes if node.type == "GROUP_OUTPUT" and node.is_active_output]
    output = tree.get_output_node("CYCLES")
    if output is not None:
        found.append(output)
    seen = set(found)
    for node in found:  # grows while it is walked
        for socket in node.inputs:
            link = link_of(socket)
            if link is not None and link.from_node not in seen:
                seen.add(link.from_node)
                found.append(link.from_node)
    return found


def link_of(socket: bpy.types.NodeSocket) -> bpy.types.NodeLink | None:
    """The link that feeds a socket, or None: muted links feed nothing."""
    return next((link for link in socket.links if not link.is_muted), None)


def unlink(tree: bpy.types.NodeTree, socket: bpy.types.NodeSocket) -> None:
    """Leave a socket to its own value."""
    for link in list(socket.links):
        tree.links.remove(link)


def move_links(tree: bpy.types.NodeTree, node: bpy.types.Node, output: bpy.types.NodeSocket) -> None:
    """Let another socket feed all that a shader node feeds."""
    for link in list(node.outputs[0].links):
        tree.links.new(output, link.to_socket)


def take(tree: bpy.types.NodeTree, source: bpy.types.NodeSocket, target: bpy.types.NodeSocket) -> None:
    """Give a socket the value and the link of another."""
    link = link_of(source)
    if link:
        tree.links.new(link.from_socket, target)
    target.default_value = source.default_value


def set_value(socket: bpy.types.NodeSocket, values: Array) -> None:
    """Set a colour or vector socket to three numbers."""
    socket.default_value = (*map(float, values), 1.0) if socket.type == "RGBA" else tuple(map(float, values))


def _metallic(tree: bpy.types.NodeTree, node: bpy.types.Node) -> bpy.types.Node:
    """The Metallic node that takes the place of a Glossy or Principled one, with its roughness and normal."""
    if node.type == "BSDF_METALLIC":
        return node
    metallic = tree.nodes.new("ShaderNodeBsdfMetallic")
    distribution = node.distribution
    metallic.distribution = distribution if distribution in {"BECKMANN", "GGX", "MULTI_GGX"} else "GGX"
    metallic.inputs["Anisotropy"].default_value = 0.0
    turned = {"Anisotropic": "Anisotropy", "Anisotropic Rotation": "Rotation"}
    for source in node.inputs:
        target = metallic.inputs.get(turned.get(source.name, source.name))
        if target is None or target.name not in {"Roughness", "Anisotropy", "Rotation", "Normal", "Tangent"}:
            continue
        take(tree, source, target)
    move_links(tree, node, metallic.outputs[0])
    tree.nodes.remove(node)
    return metallic


def metal_nodes(trees: list[bpy.types.NodeTree]) -> list[tuple[Any, Any]]:
    """The Metallic nodes of a metal, as (tree, node); at least one, or an error that says what to do."""
    found = [(tree, node) for tree, node in shaders(trees) if node.type in METAL_NODES]
    if not found:
        raise RenderError(
            "it is a metal, but has no Metallic, Glossy or Principled shader. Add a Metallic BSDF."
        )
    metallic = [(tree, _metallic(tree, node)) for tree, node in found]
    for tree, node in metallic:
        unlink(tree, node.inputs["Thin Film Thickness"])
        node.inputs["Thin Film Thickness"].default_value = 0.0
    return metallic


def measured_sockets(trees: list[bpy.types.NodeTree]) -> list[tuple[Any, Any]]:
    """The colours that a measured reflectance takes the place of, as (tree, socket)."""
    found = [
        (tree, node.inputs[MEASURED_COLOUR[node.type]])
        for tree, node in shaders(trees)
        if node.type in MEASURED_COLOUR
    ]
    if not found:
        raise RenderError(
            "it has a measured reflectance, but no Diffuse or Principled shader. Add a Diffuse BSDF."
        )
    return found
