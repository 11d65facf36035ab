"""Which version of the settings a scene has, and what is done to those of earlier ones when a file is opened or appended.

The number stands in `Scene.spectral_probe.version`. It grows by one wherever a property gets another name or meaning, and
`UPGRADES` gets a line. Settings of a later version stay in the file as they are, what is not known here too: Blender keeps
it, and the number is left alone. New properties need nothing: where they are not saved they have their defaults.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import bpy

CURRENT = 1

type Stored = Mapping[str, Any]

_LOG = logging.getLogger(__name__)


# ---------------------------------------------------------------- upgrades


def _method_without_automatic(settings: bpy.types.PropertyGroup, stored: Stored) -> None:
    """Methods had no "automatic" in their midst: what was saved as the second is the paper's."""
    if stored.get("method") == 1 and "known_light" not in stored:  # which came with it
        settings.method = "paper"


def _width_of_1024(settings: bpy.types.PropertyGroup, stored: Stored) -> None:
    """A probe's width was 1024 where nothing else was said; now it is as fine as the photographs."""
    first = "composition" not in stored and "known_light" not in stored
    if first and stored.get("views") and "probe_width" not in stored:
        settings.probe_width = 1024


UPGRADES: tuple[tuple[Callable[[bpy.types.PropertyGroup, Stored], None], ...], ...] = (
    (_method_without_automatic, _width_of_1024),  # 0: files of before there was a number
)
"""What makes settings of version n, the place in this table, those of n + 1. Each is given the settings and what was saved."""


def upgrade(scene: bpy.types.Scene) -> bool:
    """Bring a scene's settings, read from a file, to this version; whether anything was to do."""
    stored = stored_settings(scene)
    if stored is None or is_newer(scene.spectral_probe):
        return False
    before = scene.spectral_probe.version
    for number in range(before, CURRENT):
        for step in UPGRADES[number]:
            step(scene.spectral_probe, stored)
        _LOG.info("%s: settings of version %d upgraded", scene.name, number)
    scene.spectral_probe.version = CURRENT
    return before < CURRENT


def is_newer(settings: bpy.types.PropertyGroup) -> bool:
    """Whether a later version of the extension saved these settings."""
    return bool(settings.version > CURRENT)


def stored_settings(block: bpy.types.ID) -> Stored | None:
    """What a datablock holds of our settings, as it lies in the file: numbers for menus; None where it holds nothing."""
    group = block.bl_system_properties_get(do_create=False)
    return None if group is None else group.get("spectral_probe")


def stamp(scenes: Iterable[bpy.types.Scene]) -> None:
    """Note on scenes made since the file was opened that their settings are this version's."""
    for scene in scenes:
        if stored_settings(scene) is not None and scene.spectral_probe.version < CURRENT:
            scene.spectral_probe.version = CURRENT
