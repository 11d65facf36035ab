"""The verb `backplate`: a photograph as the background of a scene, with objects where the ball stood."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np

from ..spectral_probe.errors import RenderError
from ..spectral_probe.model import Job, Progress, part

if TYPE_CHECKING:
    from ..spectral_probe.composite.prepare import PreparedPlate

type Numbers = dict[str, Any]


def backplate(arguments: argparse.Namespace) -> Job[Numbers]:
    """Match the plate, set the scene up and save it; returns the numbers worth telling."""
    from ..spectral_probe.cli_backplate import match_settings
    from ..spectral_probe.composite.prepare import plate_numbers, prepare_plate
    from ..spectral_probe.figures.alignment import alignment_picture
    from ..spectral_probe.figures.panorama import write_png
    from .bridge.saving import save_scene

    output = _output(arguments)
    preparing = prepare_plate(
        arguments.probe,
        arguments.plate,
        match_settings(arguments),
        arguments.reflectance,
        arguments.ground_radius,
    )
    prepared = yield from part(preparing, 0.0, 0.9)
    yield Progress(0.9, "Setting up the scene")
    scene = _scene(arguments)
    _fill(scene, prepared, arguments)
    picture = output.with_name(f"{output.stem}_alignment.png")
    write_png(picture, alignment_picture(prepared.match, prepared.ground_radius_m))
    save_scene(output)
    return {**plate_numbers(prepared), "alignment": str(picture), "written": str(output)}


def _output(arguments: argparse.Namespace) -> Path:
    """The scene's file to write.

    Raises
    ------
    RenderError
        If it is no .blend, or the user's own scene.
    """
    from ..spectral_probe.files.atomic import check_folder

    output = Path(arguments.output).resolve()
    if output.suffix.lower() != ".blend" or output.is_dir():
        raise RenderError(f"{arguments.output} is no scene. Give a file to write such as scene.blend.")
    if arguments.scene is not None and arguments.scene.resolve() == output:
        raise RenderError(f"{output.name} is the scene itself. Give another file to write.")
    check_folder(output.parent)
    output.parent.mkdir(parents=True, exist_ok=True)
    return output


def _scene(arguments: argparse.Namespace) -> bpy.types.Scene:
    """The user's scene, or an empty one."""
    from .command_line import open_scene

    if arguments.scene is not None:
        return open_scene(arguments.scene)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.context.scene.view_settings.view_transform = "Standard"
    return bpy.context.scene


def _fill(scene: bpy.types.Scene, prepared: PreparedPlate, arguments: argparse.Namespace) -> None:
    """Camera, ground, light and objects."""
    from ..spectral_probe.geometry.frames import view_angles
    from .bridge.place_objects import place_objects, scale_of
    from .bridge.setting_up import set_up
    from .bridge.world import light_world

    matched = prepared.match.backplate
    set_up(scene, prepared)
    folder = arguments.probe.parent if arguments.probe.suffix.lower() == ".exr" else arguments.probe
    scene.spectral_probe.probe_directory = str(folder.resolve())
    if (folder / "world.exr").is_file():
        light_world(scene, (folder / "world.exr").resolve())
    if arguments.scene is None:
        heading = float(np.radians(view_angles(matched.rotation)[0]))
        names = arguments.object or ["copper-ball"]
        scale = scale_of(names[0], arguments.size, matched.ball_radius_m)
        place_objects(scene, names, scale, heading)
