"""Rendered images as 32-bit EXR files, raw numbers in the working space; and the pixels of image datablocks.

A temporary compositor tree with one File Output node writes them, not the scene's own output settings: those cannot
be put back exactly once their file format has been changed (Blender fills in a colour space that scripts cannot clear).
"""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...spectral_probe.errors import FileFormatError, RenderError
from ...spectral_probe.files.atomic import written_whole
from .restore import changed, remove


@contextmanager
def exr_renders(scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> Iterator[Callable[[Path], None]]:
    """Send the scene's renders of one view layer to EXR files while the block runs; yields the function that renders to a file.

    R, G, B, and A where the film is transparent (premultiplied). A file is written whole or not at all.
    """
    with ExitStack() as stack:
        tree = bpy.data.node_groups.new("Spectral Probe Pass", "CompositorNodeTree")
        stack.callback(remove, tree)
        source, output = tree.nodes.new("CompositorNodeRLayers"), tree.nodes.new("CompositorNodeOutputFile")
        source.scene, source.layer = scene, layer.name
        output.format.media_type = "IMAGE"
        output.format.file_format = "OPEN_EXR"
        output.format.color_mode = "RGBA" if scene.render.film_transparent else "RGB"
        output.format.color_depth = "32"
        output.file_output_items.new("RGBA", "Image")
        tree.links.new(source.outputs["Image"], output.inputs[0])
        stack.enter_context(changed(scene, compositing_node_group=tree))
        stack.enter_context(
            changed(
                scene.render,
                use_compositing=True,
                use_sequencer=False,
                compositor_device="CPU",
                compositor_precision="FULL",
            )
        )
        for other in scene.view_layers:
            if other != layer:
                stack.enter_context(changed(other, use=False))
        had_result = bpy.data.images.get("Render Result") is not None

        def render_to(path: Path) -> None:
            with written_whole(path) as temporary:
                # Braces are templates in Blender's output paths; doubled they stand for themselves.
                output.directory = str(temporary.parent).replace("{", "{{").replace("}", "}}")
                output.file_name = "render"
                bpy.ops.render.render(scene=scene.name)
                written = list(temporary.parent.glob("render*.exr"))
                if len(written) != 1:
                    raise RenderError(
                        f"Cycles did not write {path.name}. Look at Blender's console for its message."
                    )
                written[0].replace(temporary)

        try:
            yield render_to
        finally:
            result = bpy.data.images.get("Render Result")
            if result is not None and not had_result:
                remove(result)


def pixels_of(image: bpy.types.Image) -> np.ndarray[Any, np.dtype[np.float32]]:
    """Pixels (H, W, channels) of an image datablock, row 0 the image's top (Blender's is the lowest).

    Raises
    ------
    FileFormatError
        If it has no pixels, since its file is gone.
    """
    width, height = image.size
    if not width or not height:
        raise FileFormatError(f"The image {image.name} has no pixels. Choose another, or find its file.")
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(height, width, image.channels)[::-1]


def transparent_copy(picture: Path, name: str) -> bpy.types.Image:
    """A new image datablock with the colours of a picture file, all of it transparent, packed into the .blend.

    Raises
    ------
    FileFormatError
        If there is no such picture.
    """
    if not picture.is_file():
        raise FileFormatError(f"There is no picture {picture}. Build the probe again.")
    source = bpy.data.images.load(str(picture))
    try:
        pixels = np.ones((*source.size[::-1], 4), np.float32)
        own = pixels_of(source)[::-1]
        pixels[..., : min(own.shape[2], 3)] = own[..., :3]
    finally:
        bpy.data.images.remove(source)
    pixels[..., 3] = 0.0
    image = bpy.data.images.new(name, pixels.shape[1], pixels.shape[0], alpha=True)
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    image.pack()
    return image
