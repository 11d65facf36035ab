"""Calibrate the camera from photographs of a board."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.props import CollectionProperty, EnumProperty, IntProperty, StringProperty

from ..spectral_probe.errors import CaptureError
from ..spectral_probe.model import Job
from ..translations import of_core
from .base import OperatorResult
from .job import JobOperator


class SPECTRAL_PROBE_OT_calibrate(JobOperator, bpy.types.Operator):
    """Measure the lens from ten or more photographs of a chessboard or ChArUco board, tilted to all sides"""

    bl_idname = "spectral_probe.calibrate"
    bl_label = "Calibrate Camera"

    in_thread = True

    directory: StringProperty(subtype="DIR_PATH", options={"SKIP_SAVE"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"SKIP_SAVE"})
    result_name: StringProperty(  # "filename" would be the file browser's own
        name="Result", description="File to write beside the photographs", default="camera.json"
    )
    board: EnumProperty(
        name="Board",
        description="Kind of board",
        items=(
            ("auto", "Automatic", "Whatever the photographs show"),
            ("chessboard", "Chessboard", "A plain chessboard"),
            ("charuco", "ChArUco", "A chessboard with markers in its white squares"),
        ),
    )
    columns: IntProperty(name="Columns", description="Squares along one side. 0: found", min=0)
    rows: IntProperty(name="Rows", description="Squares along the other side. 0: found", min=0)

    _asked = False

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        """Ask for the photographs, unless they are given."""
        if self.files:
            return super().invoke(context, event)
        self._asked = True
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        """Called by Blender, by its file browser too: then the job is modal, so that the window stays alive."""
        if self._asked and not bpy.app.background:
            self._asked = False
            return self.reporting(lambda: self._begin(context))
        return super().execute(context)

    def job(self, _context: bpy.types.Context) -> Job[dict[str, Any]]:
        """Start with the photographs chosen."""
        from ..spectral_probe.commands import calibrate
        from ..spectral_probe.geometry.boards import board_from

        folder = Path(bpy.path.abspath(self.directory))
        photos = [folder / file.name for file in self.files if file.name]
        if not photos:
            raise CaptureError("Choose the photographs of the board, ten or more.")
        board = board_from(self.board, self.columns or None, self.rows or None, None, None, None)
        return calibrate(photos, folder / self.result_name, board)

    def done(self, context: bpy.types.Context, result: dict[str, Any]) -> None:
        """Let the capture use the calibration, and say how good it is."""
        camera = context.scene.spectral_probe.camera
        camera.calibration, camera.focal_source = result["written"], "CALIBRATION"
        told = rpt_(
            "Camera calibrated: focal length {focal:.1f} ± {error:.1f} px, error {rms:.2f} px in {count} photographs"
        )
        self.tell(
            "INFO",
            told.format(
                focal=result["focal_px"][0],
                error=result["focal_error_px"][0],
                rms=result["rms_px"],
                count=len(result["photos"]),
            ),
        )
        for dropped in result["dropped"]:
            told = rpt_("{file} was left out: {reason}")
            self.tell("WARNING", told.format(file=dropped["name"], reason=of_core(dropped["reason"])))
        for warning in result["warnings"]:
            self.tell("WARNING", warning)
