"""The assembled image denoised once by Open Image Denoise, through a compositor tree in a temporary scene.

Tristimulus values are denoised, not the working space's R, G, B: they are not negative where light is not, whatever the
gamut, and the denoiser takes what is negative for 0.

Measured in a room of coloured patterns (three passes, 8 of 128 samples each, against 384): mean dE2000 2.74 with the noise, 2.12
denoised so with the albedo in colour, 2.41 with the albedo at one wavelength, 2.45 denoised in Rec.709, 1.88 with every pass
denoised for itself. That costs a denoising for each pass and loses 0.5 % of the light, against 0.1 %, so it is not done.
"""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import bpy
import numpy as np

from ...spectral_probe.errors import RenderError
from ...spectral_probe.files.image_exr import read_rgb
from ...spectral_probe.model import Job, Progress, finish
from ...spectral_probe.work import worked
from .render_job import BlenderRender
from .restore import remove

type Array = np.ndarray[Any, Any]


def denoised(image: Array, guide: Array | None = None) -> Array:
    """An image without its noise, at once; see `denoising`."""
    return finish(denoising(Progress(0.0, "Denoising"), image, guide))


def denoising(progress: Progress, image: Array, guide: Array | None = None) -> Job[Array]:
    """An image without its noise.

    Parameters
    ----------
    progress
        What is told meanwhile.
    image
        (H, W, 3) tristimulus values.
    guide
        (H, W, 7) albedo, normal and object index (`PassImage.guide`); None denoises by the image alone.

    Returns
    -------
    ndarray
        (H, W, 3) float32, not negative.

    Raises
    ------
    RenderError
        If Blender's compositor wrote nothing.
    """
    height, width = image.shape[:2]
    with TemporaryDirectory() as folder, ExitStack() as stack:
        scene, tree = stack.enter_context(_compositor(width, height))
        denoise, output = tree.nodes.new("CompositorNodeDenoise"), tree.nodes.new("CompositorNodeOutputFile")
        features = {"Image": image}
        if guide is not None:
            features |= {"Albedo": guide[..., :3], "Normal": guide[..., 3:6]}
        for name, plane in features.items():
            source = tree.nodes.new("CompositorNodeImage")
            source.image = stack.enter_context(_float_image(f"Spectral Probe {name}", plane))
            tree.links.new(source.outputs["Image"], denoise.inputs[name])
        output.format.media_type = "IMAGE"
        output.format.file_format = "OPEN_EXR"
        output.format.color_mode = "RGB"
        output.format.color_depth = "32"
        output.directory, output.file_name = folder.replace("{", "{{").replace("}", "}}"), "denoised"
        output.file_output_items.new("RGBA", "Image")
        tree.links.new(denoise.outputs["Image"], output.inputs[0])
        render = BlenderRender(scene)
        yield replace(progress, work=render)
        render.result()
        written = list(Path(folder).glob("denoised*.exr"))
        if len(written) != 1:
            raise RenderError(
                "Blender's compositor did not denoise the image. Switch denoising off, and look at its console."
            )
        return (yield from worked(progress, partial(read_rgb, written[0])))


@contextmanager
def _compositor(width: int, height: int) -> Iterator[tuple[bpy.types.Scene, bpy.types.NodeTree]]:
    """A scene of its own with an empty compositor tree; both vanish when the block ends."""
    had_result = bpy.data.images.get("Render Result") is not None
    scene = bpy.data.scenes.new("Spectral Probe Denoise")
    tree = bpy.data.node_groups.new("Spectral Probe Denoise", "CompositorNodeTree")
    try:
        scene.compositing_node_group = tree
        render = scene.render
        render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
        render.use_compositing, render.use_sequencer = True, False
        render.compositor_device, render.compositor_precision = "CPU", "FULL"
        yield scene, tree
    finally:
        result = bpy.data.images.get("Render Result")
        for datablock in (scene, tree, *([result] if result is not None and not had_result else [])):
            remove(datablock)


@contextmanager
def _float_image(name: str, plane: Array) -> Iterator[bpy.types.Image]:
    height, width = plane.shape[:2]
    image = bpy.data.images.new(name, width, height, alpha=True, float_buffer=True, is_data=True)
    try:
        pixels = np.ones((height, width, 4), np.float32)
        pixels[..., :3] = plane[::-1]
        image.pixels.foreach_set(pixels.ravel())
        image.update()
        yield image
    finally:
        remove(image)
