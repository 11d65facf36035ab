"""Renders as multilayer EXR files of 32-bit numbers in the working space: every view layer, light group and feature pass.

A temporary compositor tree with one File Output node writes them, not the scene's own output settings: those cannot
be put back exactly once their file format has been changed (Blender fills in a colour space that scripts cannot clear).
The scene's own compositor tree and sequencer are bypassed meanwhile.
"""

import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Protocol

import bpy

from ...spectral_probe.errors import FileFormatError, RenderError
from ...spectral_probe.files.atomic import written_whole
from ...spectral_probe.files.cryptomatte import OBJECT_LEVEL
from ...spectral_probe.files.image_exr import read_channels
from ...spectral_probe.model import Job, Progress
from ...spectral_probe.render.pass_folder import ALPHA, GUIDE_ALBEDO, GUIDE_INDEX, GUIDE_NORMAL
from ...spectral_probe.render_model import WORLD
from ...spectral_probe.work import worked
from .render_job import BlenderRender
from .restore import changed, remove

_GUIDES = {
    "Denoising Albedo": ("RGBA", GUIDE_ALBEDO),
    "Denoising Normal": ("VECTOR", GUIDE_NORMAL),
    "Object Index": ("FLOAT", GUIDE_INDEX),
}
"""Outputs of a Render Layers node by which edges are told from noise: kind of the item in the file, and its name there."""

_DEPTH = 6
"""Objects that cryptomatte tells apart in one pixel, as by Blender's default; two make a level of four numbers in the file."""

_MATTES = {
    f"{OBJECT_LEVEL}{level:02d}": ("RGBA", f"{OBJECT_LEVEL}{level:02d}") for level in range(_DEPTH // 2)
}


class RenderTo(Protocol):
    """Renders to a file: its path, the light groups to keep, whether feature passes and whether mattes are wanted.

    A job; `progress` is what it tells.
    """

    def __call__(
        self, progress: Progress, path: Path, groups: Sequence[str], guide: bool, *, mattes: bool = False
    ) -> Job[None]:
        """Render."""


@contextmanager
def pass_output(scene: bpy.types.Scene, layers: Sequence[bpy.types.ViewLayer]) -> Iterator[RenderTo]:
    """Send the scene's renders of some view layers to EXR files while the block runs.

    Yields the function that renders to a file, a job: what is told meanwhile, the file's path, the names of the light groups to
    keep (`WORLD` alone is all light together), and whether feature passes, and cryptomattes of objects, are wanted, too. Channels
    are named as `render.pass_folder` says. A file is written whole or not at all.
    """
    with ExitStack() as stack:
        tree = bpy.data.node_groups.new("Spectral Probe Pass", "CompositorNodeTree")
        stack.callback(remove, tree)
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
            if other not in layers:
                stack.enter_context(changed(other, other, use=False))
        sources = [_source(tree, scene, layer) for layer in layers]
        had_result = bpy.data.images.get("Render Result") is not None

        def render_to(
            progress: Progress, path: Path, groups: Sequence[str], guide: bool, *, mattes: bool = False
        ) -> Job[None]:
            with ExitStack() as passes, written_whole(path) as temporary:
                for layer in layers if guide else ():
                    passes.enter_context(changed(layer, layer, use_pass_object_index=True))
                    passes.enter_context(changed(layer.cycles, layer, denoising_store_passes=True))
                for layer in layers if mattes else ():
                    passes.enter_context(
                        changed(layer, layer, use_pass_cryptomatte_object=True, pass_cryptomatte_depth=_DEPTH)
                    )
                further = (_GUIDES if guide else {}) | (_MATTES if mattes else {})
                output = _connect(tree, sources, groups, further, scene.render.film_transparent)
                # Braces are templates in Blender's output paths; doubled they stand for themselves.
                output.directory = str(temporary.parent).replace("{", "{{").replace("}", "}}")
                output.file_name = "render"
                render = BlenderRender(scene)
                yield replace(progress, work=render)
                render.result()
                yield from worked(progress, partial(_take, temporary, path))

        try:
            yield render_to
        finally:
            result = bpy.data.images.get("Render Result")
            if result is not None and not had_result:
                remove(result)


def _source(tree: bpy.types.NodeTree, scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> bpy.types.Node:
    """The Render Layers node of a view layer."""
    source = tree.nodes.new("CompositorNodeRLayers")
    source.scene, source.layer = scene, layer.name
    return source


def _connect(
    tree: bpy.types.NodeTree,
    sources: Sequence[bpy.types.Node],
    groups: Sequence[str],
    further: Mapping[str, tuple[str, str]],
    transparent: bool,
) -> bpy.types.Node:
    """Let the tree write these groups and features; returns its new File Output node."""
    for node in [node for node in tree.nodes if node not in sources]:
        tree.nodes.remove(node)
    output = tree.nodes.new("CompositorNodeOutputFile")
    output.format.media_type = "MULTI_LAYER_IMAGE"
    output.format.file_format = "OPEN_EXR_MULTILAYER"
    output.format.color_depth = "32"
    # Noise does not compress, and without is written and read far faster; mattes are runs of the same numbers.
    output.format.exr_codec = "RLE" if any(name.startswith(OBJECT_LEVEL) for name in further) else "NONE"
    output.format.use_exr_interleave = True
    for number, source in enumerate(sources):
        wanted = {_group_output(name, groups): ("RGBA", name) for name in groups} | further
        if transparent:
            wanted["Alpha"] = ("FLOAT", ALPHA)
        for socket_name, (kind, name) in wanted.items():
            socket = source.outputs.get(socket_name)
            if socket is None:
                raise RenderError(f'Cycles has no pass "{socket_name}" in view layer "{source.layer}".')
            output.file_output_items.new(kind, f"{number}.{name}")
            tree.links.new(socket, output.inputs[len(output.file_output_items) - 1])
    return output


def _group_output(name: str, groups: Sequence[str]) -> str:
    """Name of a Render Layers node's output that holds a light group; the image itself where there is one group only."""
    return "Image" if list(groups) == [WORLD] else f"Combined_{name}"


def _take(temporary: Path, path: Path) -> None:
    """Let what Blender wrote beside `temporary` take its place, if it is whole: Blender tells no one of a full disk."""
    written = list(temporary.parent.glob("render*.exr"))
    try:
        if len(written) != 1:
            raise FileFormatError("no file")
        read_channels(written[0])
    except FileFormatError:
        free = shutil.disk_usage(path.parent).free / 1e6
        raise RenderError(
            f"{path} could not be written; {free:.0f} MB are free there. Make room, or choose another folder, and render "
            "again: finished passes are kept."
        ) from None
    written[0].replace(temporary)
