"""Match the scene's camera to a photograph, and lay the ground in it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from mathutils import Color

from ..spectral_probe.errors import RenderError
from ..spectral_probe.model import Exposure, Job
from .job import JobOperator
from .polls import has_probe
from .settings import built_folder
from .typed import decimal, path_of

if TYPE_CHECKING:
    import numpy as np

    from ..spectral_probe.composite.ground import GroundReflectance
    from ..spectral_probe.composite.matching import MatchSettings
    from ..spectral_probe.composite.prepare import PreparedPlate


def match_settings_from(settings: bpy.types.PropertyGroup) -> MatchSettings:
    """How the plate of a scene is to be matched."""
    from ..spectral_probe.composite.matching import MatchSettings

    plate = settings.backplate
    metres = settings.id_data.unit_settings.scale_length
    exposure = None
    if plate.exposure_s:
        exposure = Exposure(decimal(plate.exposure_s), decimal(plate.iso), decimal(plate.f_number))
    return MatchSettings(
        view=plate.view,
        ground_below_m=None if plate.on_ground else decimal(plate.ground_below * metres),
        width_px=plate.width_px if plate.reduce else None,
        align=plate.align,
        exposure=exposure,
        srgb=plate.srgb,
    )


def given_reflectance(settings: bpy.types.PropertyGroup) -> np.ndarray | None:
    """The ground's reflectance in linear Rec.709 where it is given, None where the plate is to tell it."""
    import numpy as np

    plate = settings.backplate
    if plate.ground_source == "PLATE":
        return None
    return np.array(Color(plate.reflectance).from_scene_linear_to_rec709_linear(), float)


def ground_radius_m(settings: bpy.types.PropertyGroup) -> float | None:
    """Radius of the ground in metres; None where it follows the ball's."""
    return settings.backplate.ground_radius * settings.id_data.unit_settings.scale_length or None


def probe_as_built(settings: bpy.types.PropertyGroup) -> Path:
    """The folder of the probe without glasses and lamps put in: the plate was taken in its light."""
    return built_folder(settings)


class SPECTRAL_PROBE_OT_match_backplate(JobOperator, bpy.types.Operator):
    """Give the scene the photograph's camera, show it behind the camera's view, and lay the ground where the ball stood"""

    bl_idname = "spectral_probe.match_backplate"
    bl_label = "Match Plate"

    in_thread = True
    needs = ("..spectral_probe.composite.prepare",)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a probe and a photograph."""
        if not has_probe(cls, context):
            return False
        if context.scene.spectral_probe.backplate.plate:
            return True
        cls.poll_message_set("Choose the photograph first")
        return False

    def job(self, context: bpy.types.Context) -> Job[PreparedPlate]:
        """Read the settings and start."""
        from ..spectral_probe.composite.prepare import prepare_plate

        settings = context.scene.spectral_probe
        plate = path_of(settings.backplate.plate)
        if plate is None:
            raise RenderError("There is no photograph. Choose the plate.")
        return prepare_plate(
            probe_as_built(settings),
            plate,
            match_settings_from(settings),
            given_reflectance(settings),
            ground_radius_m(settings),
        )

    def done(self, context: bpy.types.Context, result: PreparedPlate) -> None:
        """Set the scene up, and say how well the plate fits."""
        from .bridge.setting_up import set_up

        plate = context.scene.spectral_probe.backplate.plate
        set_up(context.scene, result)
        _look_through_camera(context)
        context.scene.spectral_probe.backplate.plate = plate  # as chosen: it may be relative to the .blend
        alignment = result.match.alignment
        moved_px = 0.0 if alignment is None else max(map(abs, alignment.shift_px))
        told = (
            rpt_("Camera matched to {photograph}")
            if alignment is None
            else rpt_("Camera matched to {photograph}, {moved:.2f} px moved")
        )
        self.tell("INFO", told.format(photograph=result.match.backplate.photo.name, moved=moved_px))
        for remark in result.remarks:  # last, because the status bar shows the last report
            self.tell("WARNING", remark)


def _look_through_camera(context: bpy.types.Context) -> None:
    """The viewport that the button was pressed beside shows the photograph."""
    view = context.space_data if context.area is not None and context.area.type == "VIEW_3D" else None
    if view is not None:
        view.region_3d.view_perspective = "CAMERA"


class SPECTRAL_PROBE_OT_add_ground(JobOperator, bpy.types.Operator):
    """Lay the ground anew, with the reflectance and the radius of the settings; it catches shadows"""

    bl_idname = "spectral_probe.add_ground"
    bl_label = "Lay Ground"

    in_thread = True

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """The reflectance must be given, or a plate be matched."""
        plate = context.scene.spectral_probe.backplate
        if plate.ground_source == "GIVEN" or (plate.matched and has_probe(cls, context)):
            return True
        cls.poll_message_set("Match the plate first, or give the ground's reflectance")
        return False

    def job(self, context: bpy.types.Context) -> Job[tuple[GroundReflectance | np.ndarray, float]]:
        """Read the settings and start."""
        from ..spectral_probe.composite.prepare import ground_radius, measured_ground
        from .bridge.backplate import scene_backplate

        settings = context.scene.spectral_probe
        given, backplate = given_reflectance(settings), scene_backplate(context.scene)
        ball_m = settings.ball_radius * context.scene.unit_settings.scale_length
        radius_m = ground_radius(ground_radius_m(settings), backplate.ball_radius_m if backplate else ball_m)
        if given is None and backplate is None:
            raise RenderError(
                "The scene's camera is no longer that of the plate. Match the plate again, or give the ground's reflectance."
            )
        return measured_ground(probe_as_built(settings), backplate, given, radius_m)

    def done(self, context: bpy.types.Context, result: tuple[GroundReflectance | np.ndarray, float]) -> None:
        """Lay it."""
        from .bridge.setting_up import lay_ground

        ground = lay_ground(context.scene, *result)
        mean = context.scene.spectral_probe.backplate.ground_mean
        told = rpt_("{ground} reflects {reflectance}")
        self.tell(
            "INFO", told.format(ground=ground.name, reflectance=", ".join(f"{value:.2f}" for value in mean))
        )
