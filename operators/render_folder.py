"""The folder that a scene renders to, and whose it is: a copied scene, or a .blend saved elsewhere, names that of the other."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..spectral_probe.errors import RenderError
from .base import FINISHED, OperatorResult, ReportsErrors
from .settings import folder_of

_REPORT = "report.json"
_RESULTS = ("render", "comparison")


def render_folder(scene: bpy.types.Scene, *, replace: bool = False) -> Path:
    """The folder that a scene is to be rendered to.

    Parameters
    ----------
    scene
        The scene.
    replace
        The user has said that what is there may be replaced.

    Raises
    ------
    SpectralProbeError
        If it is relative to a .blend that was never saved, or holds the render of another scene or .blend, which names it too.
    """
    folder = folder_of(scene.spectral_probe.render_directory, "render")
    owner = None if replace else other_owner(scene, folder)
    if owner:
        raise RenderError(
            rpt_(
                "{folder} holds the render of {owner}, which this one would replace. Choose another folder, or press Own Folder."
            ).format(folder=folder, owner=owner)
        )
    return folder


def other_owner(scene: bpy.types.Scene, folder: Path) -> str:
    """Whose render a folder holds, where it is another scene's that renders there too, or another .blend's; else nothing.

    A .blend saved under another name in its own folder is the same work, and so is a whole folder that was copied: a render's
    report says where its .blend lies from there.
    """
    report = _report_in(folder)
    name, blend = str(report.get("scene") or ""), str(report.get("blend") or "")
    other = next((each for each in sharing_scenes(scene) if each.name == name), None)
    if other is not None:
        return rpt_('scene "{name}"').format(name=other.name)
    path = Path(os.path.normpath(folder / blend)) if blend else None
    if path is None or not bpy.data.filepath or not path.is_file():
        return ""
    return "" if path.parent == Path(bpy.data.filepath).parent else str(path)


def sharing_scenes(scene: bpy.types.Scene) -> list[bpy.types.Scene]:
    """Other scenes of the file that render to the same folder."""
    own = _absolute(scene)
    return [each for each in bpy.data.scenes if each != scene and _absolute(each) == own]


def _absolute(scene: bpy.types.Scene) -> str:
    return os.path.normpath(bpy.path.abspath(scene.spectral_probe.render_directory))


def _report_in(folder: Path) -> dict[str, object]:
    """The report of the render in a folder, or of a frame in it; empty where there is none."""
    path = folder / _REPORT
    if not path.is_file():
        path = next(iter(sorted(folder.glob(f"*/{_REPORT}"))), path)
    try:
        report = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError):
        return {}
    return report if isinstance(report, dict) else {}


class SPECTRAL_PROBE_OT_own_render_folder(ReportsErrors, bpy.types.Operator):
    """Give this scene a render folder that no other scene renders to; what was rendered stays where it is"""

    bl_idname = "spectral_probe.own_render_folder"
    bl_label = "Own Folder"

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Name the folder after the scene, and forget results that are another scene's."""
        scene = context.scene
        settings = scene.spectral_probe
        stem = settings.render_directory.rstrip("/\\") or "//spectral_probe/render"
        named = f"{stem}_{re.sub(r'[^\w.-]+', '_', scene.name)}"
        candidates = (f"{named}{end}/" for end in ("", *(f"_{number}" for number in range(2, 1000))))
        settings.render_directory = next(text for text in candidates if _is_free(scene, text))
        for result in _RESULTS:
            settings.property_unset(result)
        settings.composite.property_unset("directory")
        self.report({"INFO"}, rpt_("This scene renders to {folder}").format(folder=settings.render_directory))
        return FINISHED


def _is_free(scene: bpy.types.Scene, text: str) -> bool:
    path = os.path.normpath(bpy.path.abspath(text))
    return not Path(path).exists() and path not in {
        _absolute(each) for each in bpy.data.scenes if each != scene
    }
