"""The panorama as a Blender world: one for ordinary work, and temporary ones for the passes.

The ordinary world has two named nodes that the passes follow: whoever turns the light (Rotation of the Mapping node) or
dims it (Strength of the Background node) gets the same in the spectral render.
"""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...spectral_probe.errors import FileFormatError
from ...spectral_probe.render_model import WORLD
from .restore import changed, remove
from .shaders import link_of

ROTATION_NODE = "Spectral Probe Rotation"
LIGHT_NODE = "Spectral Probe Light"
ENVIRONMENT_NODE = "Spectral Probe Panorama"
_OURS = "spectral_probe"
"""Custom property that marks a world made here."""

FINEST_IMPORTANCE_MAP = 2048
"""Width of the map by which Cycles samples the light; finer panoramas are sampled by this one."""

type Array = np.ndarray[Any, Any]


def light_world(
    scene: bpy.types.Scene, world_exr: Path, *, rotation_rad: float = 0.0, strength: float = 1.0
) -> bpy.types.World:
    """Light a scene with a panorama for ordinary RGB work.

    Parameters
    ----------
    scene
        The scene whose world is replaced; its former world stays in the file.
    world_exr
        Scene-linear Rec.709 panorama in Blender's equirectangular frame (`world.exr` of a probe).
    rotation_rad
        Turn of the light about the vertical, counter-clockwise seen from above.
    strength
        Factor on the panorama's radiance.

    Returns
    -------
    World
        The new world, a factor `strength` times the panorama.

    Raises
    ------
    FileFormatError
        If there is no such file.
    """
    world_exr = Path(world_exr)
    if not world_exr.is_file():
        raise FileFormatError(f"There is no panorama {world_exr}. Build the probe first.")
    image = _panorama_image(world_exr)
    if scene.world is not None and scene.world.get(_OURS):
        world = scene.world
    else:
        if scene.world is not None:
            scene.world.use_fake_user = True  # without users it would be gone when the file is saved
        world = bpy.data.worlds.new("Spectral Probe")
        world[_OURS] = True
    _build(world, image, (0.0, 0.0, rotation_rad), strength)
    scene.world = world
    return world


def _build(
    world: bpy.types.World, image: bpy.types.Image, rotation: tuple[float, float, float], strength: float
) -> None:
    """Fill a world's node tree: direction, rotation, panorama, background."""
    tree = world.node_tree
    tree.nodes.clear()
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    mapping = tree.nodes.new("ShaderNodeMapping")
    environment = tree.nodes.new("ShaderNodeTexEnvironment")
    background = tree.nodes.new("ShaderNodeBackground")
    output = tree.nodes.new("ShaderNodeOutputWorld")
    mapping.name = mapping.label = ROTATION_NODE
    environment.name = environment.label = ENVIRONMENT_NODE
    background.name = background.label = LIGHT_NODE
    # "Texture" turns the panorama itself by the angle; "Point" would turn it the other way.
    mapping.vector_type = "TEXTURE"
    mapping.inputs["Rotation"].default_value = rotation
    environment.image = image
    background.inputs["Strength"].default_value = strength
    tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], environment.inputs["Vector"])
    tree.links.new(environment.outputs["Color"], background.inputs["Color"])
    tree.links.new(background.outputs["Background"], output.inputs["Surface"])
    for column, node in enumerate((coordinates, mapping, environment, background, output)):
        node.location = (column * 220.0 - 500.0, 0.0)


def follow_light(scene: bpy.types.Scene, probe_folder: Path, world_exr: Path) -> None:
    """Show another state of a probe's light in the scene's world, its rotation and strength kept.

    Nothing is done where the world is not lit by a panorama from the probe's folder. Every state is an image of its own, so that
    undoing shows the former one again.
    """
    nodes = scene.world.node_tree.nodes if scene.world is not None and scene.world.node_tree else {}
    node = nodes.get(ENVIRONMENT_NODE)
    if node is None or node.image is None:
        return
    shown = Path(bpy.path.abspath(node.image.filepath)).resolve()
    if shown.name == "world.exr" and shown.is_relative_to(probe_folder.resolve()):
        node.image = _panorama_image(world_exr)


def _panorama_image(world_exr: Path) -> bpy.types.Image:
    image = bpy.data.images.load(str(world_exr), check_existing=True)
    image.colorspace_settings.name = "Linear Rec.709"
    return image


def placement(world: bpy.types.World | None) -> tuple[tuple[float, float, float], float]:
    """Rotation (x, y, z) in radians and strength that the user gave the light of `light_world`; none and 1 without it."""
    nodes = world.node_tree.nodes if world is not None and world.node_tree is not None else {}
    rotation, strength = (0.0, 0.0, 0.0), 1.0
    if ROTATION_NODE in nodes:
        rotation = tuple(nodes[ROTATION_NODE].inputs["Rotation"].default_value)
    if LIGHT_NODE in nodes:
        strength = nodes[LIGHT_NODE].inputs["Strength"].default_value
    return rotation, strength


def volume_left_out(world: bpy.types.World | None) -> list[str]:
    """A sentence on a world's volume, which is not there while a panorama takes the world's place; none without one."""
    output = world.node_tree.get_output_node("CYCLES") if world is not None and world.node_tree else None
    if output is None or link_of(output.inputs["Volume"]) is None:
        return []
    return [f'World "{world.name}" has a volume, which was left out: the probe takes the world\'s place.']


@contextmanager
def temporary_light(scene: bpy.types.Scene, height: int, width: int) -> Iterator[Callable[[Array], None]]:
    """Light the scene with an image while the block runs; yields the function that sets its pixels (H, W, 3).

    The pixels reach Cycles as they are, in whatever working space. Rotation, strength and ray visibility are those of the
    scene's own world; it is in the light group `WORLD`.
    """
    own = scene.world
    rotation, strength = placement(own)
    with ExitStack() as stack:
        image = bpy.data.images.new(
            "Spectral Probe Pass", width, height, alpha=False, float_buffer=True, is_data=True
        )
        stack.callback(remove, image)
        image.alpha_mode = "NONE"
        world = own.copy() if own is not None else bpy.data.worlds.new("Spectral Probe Pass")
        stack.callback(remove, world)
        world.animation_data_clear()
        world.node_tree.animation_data_clear()
        world.lightgroup = WORLD
        _build(world, image, rotation, strength)
        if world.cycles.sampling_method == "AUTOMATIC":
            # By itself Cycles makes an importance map of half a million directions, in over a second, at every new light.
            world.cycles.sampling_method = "MANUAL"
            world.cycles.sample_map_resolution = min(max(width, 16), FINEST_IMPORTANCE_MAP)
        stack.enter_context(changed(scene, world=world))

        def set_pixels(pixels: Array) -> None:
            rgba = np.ones((height, width, 4), np.float32)
            rgba[..., :3] = pixels[::-1]  # Blender's first row is the lowest
            image.pixels.foreach_set(rgba.ravel())
            image.update()
            image.update_tag()  # without it Cycles' persistent data keeps the old pixels

        yield set_pixels
