"""Rendered images as 32-bit EXR files, raw numbers in the working space.

A temporary compositor tree with one File Output node writes them, not the scene's own output settings: those cannot
be put back exactly once their file format has been changed (Blender fills in a colour space that scripts cannot clear).
"""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import bpy

from ...spectral_probe.errors import RenderError
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
