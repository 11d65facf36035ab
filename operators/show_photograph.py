"""Show a photograph of a view in the Image Editor."""

from __future__ import annotations

import math
from pathlib import Path
from tempfile import mkdtemp

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.props import IntProperty

from ..spectral_probe.model import Job, Outline, Progress
from .job import JobOperator
from .pictures import show_image
from .polls import has_views
from .view_outline import Development, develop

_LARGE_PX = 2048
"""Camera raw whose half size is longer than this is shown at half size: four times as fast."""


def develop_photograph(
    path: Path, photo: int, directory: Path, outline: Outline | None, exposure_ev: float, *, half_size: bool
) -> Job[Development]:
    """Read one photograph and write its picture into `directory`."""
    from ..spectral_probe.photo.file_kind import file_kind
    from ..spectral_probe.photo.read import read_photograph

    yield Progress(0.0, rpt_("Reading {name}").format(name=path.name))
    photograph, times = read_photograph(path, half_size=True), 2
    if half_size or file_kind(path) != "raw":
        times = 1
    elif max(photograph.clipped.shape) <= _LARGE_PX:
        photograph, times = read_photograph(path), 1
    if outline is not None and times == 2:
        outline = halved(outline)
    yield Progress(0.7, rpt_("Developing {name}").format(name=path.name))
    picture, size_px = develop(
        photograph, outline, directory, f"{path.stem}_{photo + 1}", exposure_ev, times=times
    )
    return Development(picture, size_px, photo)


def halved(outline: Outline) -> Outline:
    """An outline in a photograph of half the size."""
    return Outline(
        (outline.centre_px[0] / 2, outline.centre_px[1] / 2),
        (outline.semi_axes_px[0] / 2, outline.semi_axes_px[1] / 2),
        outline.angle_rad,
        outline.points_px / 2,
        outline.rms_px / 2,
    )


class SPECTRAL_PROBE_OT_show_photograph(JobOperator, bpy.types.Operator):
    """Show a photograph of the active view in the Image Editor, with the ball's outline over it"""

    bl_idname = "spectral_probe.show_photograph"
    bl_label = "Show Photograph"

    in_thread = True

    step: IntProperty(
        name="Step",
        description="How many photographs of the view to go on from the one shown",
        default=0,
        options={"SKIP_SAVE"},
    )
    photo: IntProperty(
        name="Photograph",
        description="Number of the photograph in the view. 0: the one shown, or one in the middle of the bracket",
        default=0,
        min=0,
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be an active view."""
        return has_views(cls, context)

    def job(self, context: bpy.types.Context) -> Job[Development]:
        """Develop the photograph, unless it is shown already as it is wanted."""
        from ..spectral_probe.errors import CaptureError
        from .typed import path_of

        settings = context.scene.spectral_probe
        self._view = min(settings.active_view, len(settings.views) - 1)
        view = settings.views[self._view]
        if not view.photos:
            raise CaptureError(rpt_("The view has no photograph. Add one."))
        photo = self._chosen(view)
        path = path_of(view.photos[photo].path)
        if path is None:
            raise CaptureError(
                rpt_("Photograph {number} of the view has no file. Choose it, or remove it.").format(
                    number=photo + 1
                )
            )
        directory = Path(mkdtemp(prefix="photograph_", dir=bpy.app.tempdir))
        return develop_photograph(
            path,
            photo,
            directory,
            kept_outline(view),
            settings.overlay.exposure_ev,
            half_size=settings.camera.half_size,
        )

    def done(self, context: bpy.types.Context, result: Development) -> None:
        """Make the picture the view's image, and show it."""
        from .bridge.photograph_image import keep_picture

        views = context.scene.spectral_probe.views
        if self._view >= len(views):
            return  # the view was removed while its photograph was read
        view = views[self._view]
        keep_picture(view, result.picture, result.size_px, result.photo)
        show_image(view.shown.picture)

    def _chosen(self, view: bpy.types.PropertyGroup) -> int:
        count = len(view.photos)
        shown = view.shown.photo if view.shown.picture is not None else count // 2
        photo = self.photo - 1 if self.photo else shown + self.step
        return int(min(max(photo, 0), count - 1))


def kept_outline(view: bpy.types.PropertyGroup) -> Outline | None:
    """The outline that a view has kept, without its edge points; None without any."""
    if not view.has_outline:
        return None
    from ..spectral_probe.geometry.outline import outline_given

    return outline_given((*view.found_centre_px, *view.found_semi_axes_px, math.degrees(view.found_angle)))
