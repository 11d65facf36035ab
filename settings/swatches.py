"""The list of metals, glasses, surfaces and lamps with their swatches: the light they are shown under, and what is listed."""

from collections.abc import Callable
from typing import Any

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from . import spectrum
from .library_pickers import lamp_names


def _list_again(swatches: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    """List what is searched for, pages of refractiveindex.info among it."""
    from ..operators.bridge.swatches import SwatchShelf

    SwatchShelf.list_matching(swatches, swatches.search)


class SPECTRAL_PROBE_PG_swatch(bpy.types.PropertyGroup):
    """One entry of the list; its name is kind and name together."""

    kind: StringProperty(
        name="Kind", description="What it is for: METAL, GLASS, DISPERSIVE, REFLECTANCE or LAMP"
    )
    entry: StringProperty(name="Entry", description="Name in the library")
    label: StringProperty(name="Name", description="What people call it")
    detail: StringProperty(
        name="Detail", description="Page of refractiveindex.info, chart, or family of lamps"
    )
    source: StringProperty(name="Source", description="Publication it is from")
    licence: StringProperty(name="Licence", description="Licence of the data")
    remark: StringProperty(name="Remark", description="What somebody about to use it must know")


class SPECTRAL_PROBE_PG_swatches(bpy.types.PropertyGroup):
    """What the list shows, while Blender is open."""

    items: CollectionProperty(type=SPECTRAL_PROBE_PG_swatch, name="Swatches")
    light: StringProperty(name="Light", description="Light that the swatches are shown under")
    search: StringProperty(
        name="Search",
        description="Show only what has every word typed in its name, its page or its publication. From three letters on, all of "
        "refractiveindex.info is searched",
        options={"TEXTEDIT_UPDATE", "SKIP_SAVE"},
        update=_list_again,
    )


class SPECTRAL_PROBE_PG_swatch_light(bpy.types.PropertyGroup):
    """Under which light swatches are shown, and what choosing one does."""

    light: EnumProperty(
        name="Swatches Under",
        description="Light under which the swatches are shown. A perfect white is white in each: the eye is taken to be "
        "adapted to the light, completely (CAT16, CIE 1931 observer), and colours are as the screen shows them without "
        "view transform",
        items=(
            (
                "SCENE",
                "Scene's Light",
                "Mean light of the probe over all directions that were seen; D65 where there is none",
            ),
            ("DIRECTION", "Direction", "Light of the probe from one direction"),
            ("LAMP", "Lamp", "A CIE illuminant or another lamp of the library"),
        ),
    )
    azimuth: spectrum.bearing()
    elevation: spectrum.height()
    lamp: StringProperty(
        name="Lamp",
        description='A light of the library, such as "D65", "A", "FL11" or "Planck 3200 K"',
        default="D65",
        search=lamp_names,
        search_options={"SUGGESTION"},
    )
    set_look: BoolProperty(
        name="Set Look Too",
        description="Choosing from the list also gives the material's shaders its colours under D65, for the viewport and for "
        "RGB renders. Textures and other nodes stay; a shader is added only where none fits, and nothing is deleted",
        default=True,
    )


def chosen_surface() -> Any:
    """Which entry of the list a material is made of; setting it chooses another."""
    return _chosen(lambda settings: settings.kind)


def chosen_lamp() -> Any:
    """Which entry of the list a lamp is, or what a material emits; setting it chooses another."""
    return _chosen(lambda settings: settings.light)


def _chosen(kind: Callable[[bpy.types.PropertyGroup], str]) -> Any:
    def index_of(settings: bpy.types.PropertyGroup) -> int:
        from ..operators.bridge.choosing import entry_of

        listed = bpy.context.window_manager.spectral_probe_swatches.items
        return listed.find(f"{kind(settings)}|{entry_of(settings, kind(settings))}")

    def choose_at(settings: bpy.types.PropertyGroup, index: int) -> None:
        from ..operators.bridge.choosing import choose

        listed = bpy.context.window_manager.spectral_probe_swatches.items
        if 0 <= index < len(listed):
            look = bpy.context.scene.spectral_probe.swatches.set_look
            choose(settings.id_data, listed[index].kind, listed[index].entry, look=look)

    return IntProperty(
        name="Chosen", description="Choose from the list", get=index_of, set=choose_at, options=set()
    )


CLASSES: tuple[type[Any], ...] = (
    SPECTRAL_PROBE_PG_swatch,
    SPECTRAL_PROBE_PG_swatches,
    SPECTRAL_PROBE_PG_swatch_light,
)
"""To be registered before the scene's settings."""


def register() -> None:
    """Give the window manager its list."""
    bpy.types.WindowManager.spectral_probe_swatches = PointerProperty(
        type=SPECTRAL_PROBE_PG_swatches, name="Swatches", options={"SKIP_SAVE"}
    )


def unregister() -> None:
    """Take it back."""
    del bpy.types.WindowManager.spectral_probe_swatches
