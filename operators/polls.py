"""Why a button is grey: conditions that several operators share."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.app.translations import pgettext_n as n_
from bpy.app.translations import pgettext_rpt as rpt_

from .missing import still_missing
from .settings import probe_folder
from .typed import path_of

_BUILD_FIRST = n_("Build the probe first")

type OperatorClass = type[bpy.types.Operator]


def has_views(operator: OperatorClass, context: bpy.types.Context) -> bool:
    """The scene has at least one view."""
    if context.scene.spectral_probe.views:
        return True
    operator.poll_message_set("Import a capture or add a view first")
    return False


def has_photographs(operator: OperatorClass, context: bpy.types.Context) -> bool:
    """The scene has a view, and none of its photographs was missing when the file was opened and still is."""
    if not has_views(operator, context):
        return False
    gone = set(still_missing(context))
    photos = (
        [photo.path for view in context.scene.spectral_probe.views for photo in view.photos] if gone else []
    )
    count = sum(str(path_of(path)) in gone for path in photos)
    if count:
        text = rpt_(
            "Photographs are missing: {count}. Find them with File > External Data > Find Spectral Probe Files"
        )
        operator.poll_message_set(text.format(count=count))
    return not count


def has_light(operator: OperatorClass, context: bpy.types.Context) -> bool:
    """There is a probe, or the scene is lit by its own world and lamps."""
    if context.scene.spectral_probe.light == "WORLD":
        return True
    return has_probe(operator, context, "Build the probe first, or set Light to Own World")


def has_probe(operator: OperatorClass, context: bpy.types.Context, message: str = _BUILD_FIRST) -> bool:
    """A probe was built, or its folder chosen."""
    settings = context.scene.spectral_probe
    directory = str(probe_folder(settings)) if settings.probe_directory else ""
    if settings.packed.files:
        message = n_("The files of the probe are gone. Unpack it: the .blend holds a copy")
    elif settings.probe_directory and probe_folder(settings).parent.name == "edits":
        message = n_("The files of the edited light are gone. Build the probe again, or choose its folder")
    elif settings.probe.width_px and settings.probe_directory:
        message = n_(
            "The files of the probe are gone. Find them (File > External Data), choose its folder, or build it again"
        )
    return _has_file(operator, directory, "probe.exr", message)


def has_edits(operator: OperatorClass, context: bpy.types.Context) -> bool:
    """The probe has a glass or a lamp that can be taken back."""
    if context.scene.spectral_probe.edits.items:
        return True
    operator.poll_message_set("Add a glass or a lamp first")
    return False


def has_region(operator: OperatorClass, context: bpy.types.Context) -> bool:
    """The region of the panel is given."""
    region = context.scene.spectral_probe.region
    if region.kind == "POLYGON" and not region.polygon.strip():
        operator.poll_message_set("Give the corners of the polygon first")
        return False
    if region.kind == "MASK" and region.mask is None:
        operator.poll_message_set("Choose or make a mask first")
        return False
    return True


def has_render(operator: OperatorClass, context: bpy.types.Context) -> bool:
    """The scene was rendered spectrally, and in RGB."""
    directory = context.scene.spectral_probe.render_directory
    return _has_file(operator, directory, "xyz.exr", "Render the scene spectrally first") and _has_file(
        operator,
        directory,
        "rgb.exr",
        "Render again with Also RGB on; there is no RGB render to compare with",
    )


def has_render_files(operator: OperatorClass, context: bpy.types.Context, name: str, message: str) -> bool:
    """The folder of the render has a file; `message` says what to do where it has not."""
    return _has_file(operator, context.scene.spectral_probe.render_directory, name, message)


def in_object_mode(operator: OperatorClass, context: bpy.types.Context) -> bool:
    """Objects can be added."""
    if context.mode == "OBJECT":
        return True
    operator.poll_message_set("Switch to object mode first")
    return False


def uses_cycles(operator: OperatorClass, context: bpy.types.Context) -> bool:
    """The scene is rendered by Cycles."""
    if context.scene.render.engine == "CYCLES":
        return True
    operator.poll_message_set("Set the render engine to Cycles; EEVEE only approximates metals")
    return False


def _has_file(operator: OperatorClass, directory: str, name: str, message: str) -> bool:
    if directory and (Path(bpy.path.abspath(directory)) / name).is_file():
        return True
    operator.poll_message_set(message)
    return False
