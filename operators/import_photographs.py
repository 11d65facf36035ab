"""Photographs of the ball into views: from a file browser, dropped on a window, or from a script."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, StringProperty

from ..preferences import library_folder
from ..spectral_probe.errors import CaptureError
from ..spectral_probe.model import Capture, Job
from .base import OperatorResult
from .import_capture import describe
from .job import JobOperator
from .photograph_choice import of_the_ball
from .photograph_files import BROWSED, DROPPED_SUFFIXES, Found, chosen_files, look_at
from .photograph_views import (
    add_views,
    assume_equal_exposures,
    assume_lens,
    choose_camera,
    folders_beside,
    named,
    paths_in,
    remarks,
    summary,
)
from .settings import fill

if TYPE_CHECKING:  # heavy: imported where it is used
    from ..spectral_probe.photo.grouping import Grouping

_PLACES = {"VIEW_3D", "IMAGE_EDITOR", "PROPERTIES"}


class SPECTRAL_PROBE_OT_import_photographs(JobOperator, bpy.types.Operator):
    """Import photographs of a mirrored ball, and sort them into brackets and views by their exposures and times"""

    bl_idname = "spectral_probe.import_photographs"
    bl_label = "Import Photographs"

    in_thread = True

    filepath: StringProperty(name="File", subtype="FILE_PATH", options={"SKIP_SAVE", "HIDDEN"})
    directory: StringProperty(name="Folder", subtype="DIR_PATH", options={"SKIP_SAVE", "HIDDEN"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"SKIP_SAVE", "HIDDEN"})
    filter_glob: StringProperty(default=BROWSED, options={"HIDDEN", "SKIP_SAVE"})
    filter_image: BoolProperty(default=True, options={"HIDDEN", "SKIP_SAVE"})
    filter_folder: BoolProperty(default=True, options={"HIDDEN", "SKIP_SAVE"})
    views: EnumProperty(
        name="Views",
        description="How photographs are sorted into views; they can be moved from one to another afterwards",
        items=(
            (
                "AUTOMATIC",
                "Automatic",
                "By exposure, time, camera and lens; by names where files do not say these",
            ),
            ("ONE", "One View", "All photographs are one bracket"),
            ("EACH", "One Each", "Every photograph is a view of its own"),
        ),
    )
    replace: BoolProperty(
        name="Replace",
        description="Remove the views that are there first, instead of adding to them",
        options={"SKIP_SAVE"},
    )
    use_capture_file: BoolProperty(
        name="Use Capture File",
        description="Where a capture file beside the photographs names just these, take camera, ball and angles from it",
        default=True,
    )

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        """Ask for the photographs, unless they were dropped on the window."""
        if self.files or self.filepath:
            return super().invoke(context, event)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def job(self, context: bpy.types.Context) -> Job[Found]:
        """Look at the files."""
        paths = chosen_files(self.directory, (file.name for file in self.files), self.filepath)
        fresh = self.replace or not context.scene.spectral_probe.views
        return look_at(
            paths,
            use_capture_file=self.use_capture_file and self.views == "AUTOMATIC" and fresh,
            library=library_folder(),
        )

    def done(self, context: bpy.types.Context, result: Found) -> None:
        """Fill the settings, and say what was made of the photographs and what was not."""
        settings = context.scene.spectral_probe
        if result.capture is not None:
            path, capture = result.capture
            fill(settings, capture, path)
            told = _not_in_capture(capture, result.grouping)
            report = rpt_("{contents}, as {file} says").format(contents=describe(capture), file=path.name)
        else:
            report, told = self._add(settings, result)
        for warning in (*result.refused, *told):
            self.tell("WARNING", warning)
        self.tell("INFO", report)

    def _add(self, settings: bpy.types.PropertyGroup, result: Found) -> tuple[str, list[str]]:
        """Add views for photographs that no capture file describes; the report, and warnings."""
        grouping, told = self._new(settings, result)
        if self.replace:
            settings.views.clear()
            settings.active_view = 0
            settings.capture_path = ""
        first = len(settings.views) + 1
        add_views(settings, grouping.views)
        equal = assume_equal_exposures(settings, grouping.views)
        choose_camera(settings, result.camera)
        folders_beside(settings, grouping.views[0].photos[0].path.parent)
        model = settings.camera.model or settings.camera.sensitivities
        told += remarks(grouping, first, equal, model) + assume_lens(settings, grouping.views)
        count = sum(len(view.photos) for view in settings.views)
        return summary(settings, count), told

    def _new(self, settings: bpy.types.PropertyGroup, result: Found) -> tuple[Grouping, list[str]]:
        """Photographs that the scene does not have yet, in views as asked for; and a sentence on those that it has.

        Raises
        ------
        CaptureError
            If none is left.
        """
        from ..spectral_probe.photo.grouping import ViewGroup

        known = set() if self.replace else paths_in(settings)
        present, views = [], []
        for view in result.grouping.views:
            present += [photo.name for photo in view.photos if photo.path.resolve() in known]
            photos = tuple(photo for photo in view.photos if photo.path.resolve() not in known)
            if photos:
                views.append(dataclasses.replace(view, photos=photos))
        if not views:
            if present:
                raise CaptureError(
                    rpt_("All {count} photographs are in a view already.").format(count=len(present))
                )
            raise CaptureError(result.refused[0] if result.refused else "Choose at least one photograph.")
        photos = tuple(photo for view in views for photo in view.photos)
        told = [rpt_("{files} left out: in a view already").format(files=named(present))] if present else []
        if self.views == "AUTOMATIC":
            views, left_out = of_the_ball(views)
            told += left_out
            if not views:
                raise CaptureError(told[-1])
        elif self.views == "ONE":
            views = [ViewGroup(photos)]
        elif self.views == "EACH":
            views = [ViewGroup((photo,)) for photo in photos]
        return dataclasses.replace(result.grouping, views=tuple(views)), told


class SPECTRAL_PROBE_FH_photographs(bpy.types.FileHandler):
    """Photographs and capture files may be dropped where they are used."""

    bl_idname = "SPECTRAL_PROBE_FH_photographs"
    bl_label = "Mirrored Ball Photographs"
    bl_import_operator = "spectral_probe.import_photographs"
    bl_file_extensions = DROPPED_SUFFIXES

    @classmethod
    def poll_drop(cls, context: bpy.types.Context) -> bool:
        """Where the scene, its pictures or its settings are shown."""
        return context.area is not None and context.area.type in _PLACES


def _not_in_capture(capture: Capture, given: Grouping) -> list[str]:
    """A sentence on photographs that were given beside a capture file which does not name them; none where there are none."""
    wanted = {photo.resolve() for view in capture.views for photo in view.photos}
    photographs = [*(photo for view in given.views for photo in view.photos), *given.beside_raw]
    others = [photo.name for photo in photographs if photo.path.resolve() not in wanted]
    return (
        [rpt_("{files} left out: the capture file does not name them").format(files=named(others))]
        if others
        else []
    )
