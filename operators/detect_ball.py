"""Find the ball's outline in the photographs and show it."""

from dataclasses import dataclass
from pathlib import Path
from tempfile import mkdtemp

import bpy

from ..spectral_probe.model import Job, Outline, Progress, ViewSettings
from .job import JobOperator
from .pictures import show
from .polls import has_photographs
from .settings import capture_from


@dataclass(frozen=True)
class FoundOutline:
    """The outline in the view of this number (from 0), and a picture of it."""

    view: int
    outline: Outline
    picture: Path
    warnings: tuple[str, ...] = ()


def find_outlines(
    views: dict[int, ViewSettings], directory: Path, *, half_size: bool = False
) -> Job[list[FoundOutline]]:
    """Detect the outline in each view, or take the circle given, and draw it into `directory`."""
    from ..spectral_probe.figures.display import write_png
    from ..spectral_probe.figures.outline import outline_picture
    from ..spectral_probe.geometry.outline import check_in_frame, find_ball, outline_from_circle
    from ..spectral_probe.photo.read import read_photograph

    found = []
    for done, (number, view) in enumerate(views.items()):
        yield Progress(done / len(views), f"View {number + 1}: reading {len(view.photos)} photographs")
        photographs = [read_photograph(path, half_size=half_size) for path in view.photos]
        yield Progress((done + 0.6) / len(views), f"View {number + 1}: finding the ball")
        warnings: tuple[str, ...] = ()
        if view.outline is None:
            ball = find_ball(photographs, ball_at=view.ball_at)
            outline, warnings = ball.outlines[0], ball.warnings
        else:
            outline = outline_from_circle(*view.outline)
            height, width = photographs[0].pixels.shape[:2]
            check_in_frame(outline, (width, height), given=True)
        picture = directory / f"outline_{number + 1}.png"
        write_png(picture, outline_picture(photographs[len(photographs) // 2], outline))
        found.append(FoundOutline(number, outline, picture, warnings))
    return found


class SPECTRAL_PROBE_OT_detect_ball(JobOperator, bpy.types.Operator):
    """Find the ball's outline in the photographs and show it in the image editor"""

    bl_idname = "spectral_probe.detect_ball"
    bl_label = "Detect Ball"

    in_thread = True

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be photographs."""
        return has_photographs(cls, context)

    def job(self, context: bpy.types.Context) -> Job[list[FoundOutline]]:
        """Look in every view, or in the active one."""
        settings = context.scene.spectral_probe
        views = dict(enumerate(capture_from(settings).views))
        if settings.all_views:  # through a filter the ball is where it is without
            views = {number: view for number, view in views.items() if view.filter is None} or views
        else:
            views = {settings.active_view: views[settings.active_view]}
        directory = Path(mkdtemp(prefix="outlines_", dir=bpy.app.tempdir))
        return find_outlines(views, directory, half_size=settings.camera.half_size)

    def done(self, context: bpy.types.Context, result: list[FoundOutline]) -> None:
        """Keep the outlines in the views; show that of the active view."""
        settings = context.scene.spectral_probe
        for found in result:
            view, outline = settings.views[found.view], found.outline
            view.has_outline = True
            view.found_centre_px = outline.centre_px
            view.found_semi_axes_px = outline.semi_axes_px
            view.found_angle = outline.angle_rad
            view.found_rms_px = outline.rms_px
            if view.outline_source == "AUTOMATIC":  # a start for whoever wants to correct it by hand
                view.outline_px = (*outline.centre_px, sum(outline.semi_axes_px) / 2)
        shown = next((found for found in result if found.view == settings.active_view), result[0])
        show(shown.picture, f"Outline {shown.view + 1}")
        worst_px = max(found.outline.rms_px for found in result)
        self.report({"INFO"}, f"Ball found in {len(result)} view(s), RMS at most {worst_px:.2f} px")
        for found in result:
            for warning in found.warnings:
                self.report({"WARNING"}, warning)
