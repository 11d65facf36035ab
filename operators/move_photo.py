"""Photographs between views, where they were sorted wrongly; and views round the ball."""

from __future__ import annotations

import math

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    StringProperty,
)

from ..spectral_probe.errors import CaptureError
from ..spectral_probe.geometry.bearings import even_bearings_deg
from .base import FINISHED, OperatorResult, ReportsErrors
from .photograph_files import BROWSED, chosen_files
from .photograph_views import name_view, paths_in, place_views
from .polls import has_views
from .settings import add_photos

_PHOTO_FIELDS = ("path", "exposure_s", "iso", "f_number")


class OnPhotograph(ReportsErrors):
    """Mixin: works on the active photograph of the active view."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be one."""
        settings = context.scene.spectral_probe
        if settings.active_view < len(settings.views):
            view = settings.views[settings.active_view]
            if view.active_photo < len(view.photos):
                return True
        cls.poll_message_set(rpt_("Choose a photograph of a view first"))
        return False


class SPECTRAL_PROBE_OT_move_photo(OnPhotograph, bpy.types.Operator):
    """Move the active photograph to another view, or to a new one"""

    bl_idname = "spectral_probe.move_photo"
    bl_label = "Move Photograph"

    view: IntProperty(name="View", description="Number of the view to move it to. 0: a new one", min=0)
    following: BoolProperty(
        name="And All After It",
        description="Move the photographs after it as well, such as where a bracket was not told from the next",
    )

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Move it; a view that has none left goes."""
        settings = context.scene.spectral_probe
        if self.view > len(settings.views):
            raise CaptureError(rpt_("There is no view {number}.").format(number=self.view))
        source_index = settings.active_view
        if self.view == source_index + 1:
            return FINISHED
        first = settings.views[source_index].active_photo
        last = len(settings.views[source_index].photos) if self.following else first + 1
        target_index = self.view - 1 if self.view else _insert_view(settings, source_index)
        _move(settings, source_index, target_index, range(first, last))
        if not settings.views[source_index].photos:
            settings.views.remove(source_index)
            target_index -= target_index > source_index
        settings.active_view = target_index
        return FINISHED


class SPECTRAL_PROBE_OT_remove_photo(OnPhotograph, bpy.types.Operator):
    """Remove the active photograph from its view; its file stays on disk"""

    bl_idname = "spectral_probe.remove_photo"
    bl_label = "Remove Photograph"

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Remove it, and the view with its last one."""
        settings = context.scene.spectral_probe
        view = settings.views[settings.active_view]
        view.photos.remove(view.active_photo)
        view.active_photo = max(0, min(view.active_photo, len(view.photos) - 1))
        view.has_probe = False
        if not view.photos:
            settings.views.remove(settings.active_view)
            settings.active_view = max(0, min(settings.active_view, len(settings.views) - 1))
        return FINISHED


class SPECTRAL_PROBE_OT_add_photos(ReportsErrors, bpy.types.Operator):
    """Add photographs to the active view: further exposures of its bracket"""

    bl_idname = "spectral_probe.add_photos"
    bl_label = "Add Photographs to View"

    directory: StringProperty(subtype="DIR_PATH", options={"SKIP_SAVE", "HIDDEN"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"SKIP_SAVE", "HIDDEN"})
    filter_glob: StringProperty(default=BROWSED, options={"HIDDEN", "SKIP_SAVE"})
    filter_image: BoolProperty(default=True, options={"HIDDEN", "SKIP_SAVE"})
    filter_folder: BoolProperty(default=True, options={"HIDDEN", "SKIP_SAVE"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a view."""
        return has_views(cls, context)

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        """Ask for the photographs."""
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Append those that no view has yet."""
        from ..spectral_probe.photo.metadata import read_record

        settings = context.scene.spectral_probe
        paths = chosen_files(self.directory, (file.name for file in self.files), "")
        known = paths_in(settings)
        added = [path for path in paths if path.resolve() not in known]
        if not added:
            raise CaptureError(
                rpt_("These photographs are in a view already: {count}.").format(count=len(paths))
            )
        for path in added:
            read_record(path)  # refuses what is no photograph, before any is added
        view = settings.views[min(settings.active_view, len(settings.views) - 1)]
        add_photos(view, added)
        view.active_photo = len(view.photos) - 1
        view.has_probe = False
        self.report(
            {"INFO"}, rpt_("{count} photographs added to {view}").format(count=len(added), view=view.name)
        )
        return FINISHED


class SPECTRAL_PROBE_OT_join_views(ReportsErrors, bpy.types.Operator):
    """Join the active view with the one before it or after it: their photographs are one bracket"""

    bl_idname = "spectral_probe.join_views"
    bl_label = "Join Views"

    other: EnumProperty(
        name="With",
        description="The view that is joined with the active one",
        items=(("BEFORE", "View Before", "The view above it"), ("AFTER", "View After", "The view below it")),
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be two."""
        if len(context.scene.spectral_probe.views) > 1:
            return True
        cls.poll_message_set(rpt_("There is no other view to join with"))
        return False

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Move all photographs of the later one into the earlier one, which stays."""
        settings = context.scene.spectral_probe
        first = settings.active_view - (self.other == "BEFORE")
        if not 0 <= first < len(settings.views) - 1:
            raise CaptureError(rpt_("There is no view there to join with. Choose another view."))
        _move(settings, first + 1, first, range(len(settings.views[first + 1].photos)))
        settings.views.remove(first + 1)
        settings.active_view = first
        return FINISHED


class SPECTRAL_PROBE_OT_spread_views(ReportsErrors, bpy.types.Operator):
    """Give all views bearings evenly round the ball, in the order of the list"""

    bl_idname = "spectral_probe.spread_views"
    bl_label = "Spread Views Evenly"

    first: FloatProperty(
        name="First Bearing", description="Compass bearing of the first view", subtype="ANGLE"
    )
    clockwise: BoolProperty(
        name="Clockwise",
        description="The camera's bearing turned clockwise, seen from above, from one view to the next",
        default=True,
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a view."""
        return has_views(cls, context)

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Set the bearings."""
        views = context.scene.spectral_probe.views
        bearings_deg = even_bearings_deg(len(views), math.degrees(self.first), clockwise=self.clockwise)
        for view, bearing_deg in zip(views, bearings_deg, strict=True):
            view.azimuth = math.radians(bearing_deg)
        return FINISHED


def _insert_view(settings: bpy.types.PropertyGroup, after: int) -> int:
    """Add a view after another one, and give it a bearing; returns its index."""
    settings.views.add()
    settings.views.move(len(settings.views) - 1, after + 1)
    place_views(settings, range(after + 1, after + 2))
    return after + 1


def _move(settings: bpy.types.PropertyGroup, source_index: int, target_index: int, numbers: range) -> None:
    """Move photographs of one view to the end of another."""
    source, target = settings.views[source_index], settings.views[target_index]
    for number in numbers:
        photo = target.photos.add()
        for field in _PHOTO_FIELDS:
            setattr(photo, field, getattr(source.photos[number], field))
    for number in reversed(numbers):
        source.photos.remove(number)
    name_view(target)
    target.active_photo = len(target.photos) - len(numbers)
    source.active_photo = max(0, min(source.active_photo, len(source.photos) - 1))
    source.has_probe = target.has_probe = False
