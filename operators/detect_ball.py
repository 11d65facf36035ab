"""Find the ball's outline in the photographs and show it."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import mkdtemp

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..spectral_probe.errors import CaptureError
from ..spectral_probe.model import Capture, Job, Photograph, Progress
from .job import JobOperator
from .pictures import show_image
from .polls import has_photographs
from .settings import capture_from
from .view_outline import Development, ViewOutline, develop, keep_outline, outline_in


@dataclass(frozen=True)
class FoundOutline:
    """The outline in the view of this number (from 0), and a picture of one of its photographs."""

    view: int
    found: ViewOutline
    development: Development


def find_outlines(
    capture: Capture, numbers: list[int], directory: Path, exposure_ev: float = 0.0
) -> Job[list[FoundOutline]]:
    """Find the outline in each of the views, or take the one given, and develop a photograph into `directory`."""
    from ..spectral_probe.photo.read import read_photograph

    results = []
    for done, number in enumerate(numbers):
        view = capture.views[number]
        yield Progress(
            done / len(numbers),
            rpt_("View {view}: reading {photos} photographs").format(
                view=number + 1, photos=len(view.photos)
            ),
        )
        photographs = [read_photograph(path, half_size=capture.camera.half_size) for path in view.photos]
        yield Progress(
            (done + 0.6) / len(numbers), rpt_("View {view}: finding the ball").format(view=number + 1)
        )
        found = outline_in(photographs, view, capture)
        results.append(with_picture(number, found, photographs, directory, exposure_ev))
    return results


def with_picture(
    number: int, found: ViewOutline, photographs: Sequence[Photograph], directory: Path, exposure_ev: float
) -> FoundOutline:
    """An outline with a picture of the photograph in the middle of its bracket, developed into `directory`."""
    photo = len(photographs) // 2
    name = f"view_{number + 1}_{photo + 1}"
    picture, size_px = develop(photographs[photo], found.outline, directory, name, exposure_ev)
    return FoundOutline(number, found, Development(picture, size_px, photo))


def views_with_balls(capture: Capture) -> list[int]:
    """The views to look for the ball in: through a filter it is where it is without."""
    everything = list(range(len(capture.views)))
    return [number for number in everything if capture.views[number].filter is None] or everything


class SPECTRAL_PROBE_OT_detect_ball(JobOperator, bpy.types.Operator):
    """Find the ball's outline in the photographs and show it in the Image Editor"""

    bl_idname = "spectral_probe.detect_ball"
    bl_label = "Detect Ball"

    in_thread = True
    needs = ("..spectral_probe.geometry.outline", "..spectral_probe.photo.read", ".view_outline")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be photographs."""
        return has_photographs(cls, context)

    def job(self, context: bpy.types.Context) -> Job[list[FoundOutline]]:
        """Look in every view, or in the active one."""
        settings = context.scene.spectral_probe
        capture = capture_from(settings)
        numbers = views_with_balls(capture) if settings.all_views else [settings.active_view]
        directory = Path(mkdtemp(prefix="outlines_", dir=bpy.app.tempdir))
        return find_outlines(capture, numbers, directory, settings.overlay.exposure_ev)

    def done(self, context: bpy.types.Context, result: list[FoundOutline]) -> None:
        """Keep the outlines in the views; show that of the active view."""
        keep_found(self, context, result)


def keep_found(
    operator: JobOperator,
    context: bpy.types.Context,
    result: list[FoundOutline],
    *,
    in_new_window: bool = True,
) -> None:
    """Keep the outlines in the views, show that of the active view, and tell how good they are."""
    from .bridge.photograph_image import keep_picture

    settings = context.scene.spectral_probe
    if max(one.view for one in result) >= len(settings.views):
        raise CaptureError(rpt_("Views were removed meanwhile. Detect the ball again."))
    for one in result:
        view, picture = settings.views[one.view], one.development
        keep_outline(view, one.found)
        keep_picture(view, picture.picture, picture.size_px, picture.photo)
    shown = next((one for one in result if one.view == settings.active_view), result[0])
    show_image(settings.views[shown.view].shown.picture, in_new_window=in_new_window)
    worst_px = max(one.found.outline.rms_px for one in result)
    operator.tell(
        "INFO",
        rpt_("Ball found in {views} view(s), RMS at most {rms:.2f} px").format(
            views=len(result), rms=worst_px
        ),
    )
    for one in result:
        for warning in one.found.warnings:
            operator.tell("WARNING", warning)
