"""Where the panels are, and what they are laid out with.

The light is in Properties > World, the render in Properties > Render, what needs a viewport or a picture in its sidebar.
"""

import textwrap
from typing import ClassVar

import bpy
from bpy.app.translations import pgettext_iface as iface_

from ..translations import of_core
from .job_report import draw_report

_LETTER_PX = 6.2  # mean width of a letter in Blender's default font, at a resolution scale of 1
_MARGINS_PX = 80  # of the region's width: tabs, frames and an icon


class InWorld:
    """Mixin: a child panel of Spectral Probe in Properties > World."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "world"
    bl_parent_id = "SPECTRAL_PROBE_PT_light_probe"


class InRender:
    """Mixin: a closed child panel of Spectral Render in Properties > Render."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    bl_parent_id = "SPECTRAL_PROBE_PT_render"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}


class InImageEditor:
    """Mixin: a panel of the Spectral Probe tab in the Image Editor's sidebar."""

    bl_space_type = "IMAGE_EDITOR"
    bl_region_type = "UI"
    bl_category = "Spectral Probe"


class InSidebar:
    """Mixin: a child panel of the Spectral Probe tab in the 3D viewport's sidebar."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Spectral Probe"
    bl_parent_id = "SPECTRAL_PROBE_PT_main"


class InProperties:
    """Mixin: a closed panel of the properties editor."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}


def job_button(layout: bpy.types.UILayout, context: bpy.types.Context, operator: str, icon: str) -> None:
    """The button of a long job; its progress while it runs."""
    running = context.window_manager.spectral_probe
    if running.operator == operator:
        column = layout.column(align=True)
        column.progress(factor=running.fraction, text=f"{running.fraction:.0%}")
        paragraph(
            column, context, running.message or "Starting", "NONE"
        )  # too long for the bar: it would be cut
    else:
        layout.operator(operator, icon=icon)
        draw_report(layout, context, operator)


def results(layout: bpy.types.UILayout) -> bpy.types.UILayout:
    """A box for what was found, name by name; nothing in it can be edited."""
    column = layout.box().column(align=True)
    column.scale_y = 0.8
    return column


def row(column: bpy.types.UILayout, name: str, value: str) -> None:
    """One result: its name on the left, the value on the right."""
    split = column.split(factor=0.5)
    names = split.row()
    names.active = False
    names.label(text=name)
    split.label(text=value)


def paragraph(column: bpy.types.UILayout, context: bpy.types.Context, text: str, icon: str) -> None:
    """A text too long for one line, broken to the width of its region."""
    region_px = context.region.width if context.region is not None else 0
    scale = context.preferences.system.ui_scale or 1.0  # 0 without a window
    letters = int((region_px / scale - _MARGINS_PX) / _LETTER_PX)
    words = of_core(iface_(text)) if text else ""
    for index, line in enumerate(textwrap.wrap(words, max(letters, 20))):
        column.label(text=line, icon="BLANK1" if index and icon != "NONE" else icon, translate=False)


def cells(column: bpy.types.UILayout, *texts: str, active: bool = True) -> None:
    """One row of a table of equal columns."""
    grid = column.row()
    grid.active = active
    for text in texts:
        grid.label(text=text)


def settings_layout(layout: bpy.types.UILayout) -> bpy.types.UILayout:
    """A column of settings, names on the left, nothing to be keyed."""
    column = layout.column()
    column.use_property_split = True
    column.use_property_decorate = False
    return column


def name_or_file(column: bpy.types.UILayout, owner: bpy.types.AnyType, name: str) -> None:
    """A name of the library, grey where a file takes its place, and that file."""
    named = column.column()
    named.active = not getattr(owner, f"{name}_path")
    named.prop(owner, name)
    column.prop(owner, f"{name}_path", text="File")


def duration(seconds: float) -> str:
    """Seconds in words.

    Examples
    --------
    >>> duration(8.25), duration(75.0)
    ('8.3 s', '1 min 15 s')
    """
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest} s"
