"""What follows a file that is opened, joined with another, or saved: upgraded settings, paths, packed probes, missing files."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from pathlib import Path

import bpy
from bpy.app.handlers import persistent

from . import versions
from .operators.bridge import own_paths, packed_probe
from .operators.job_report import forget_reports
from .operators.missing import keep_missing
from .operators.settings import built_folder
from .spectral_probe.errors import SpectralProbeError

_LOG = logging.getLogger(__name__)


@persistent
def _loaded(*_: object) -> None:
    forget_reports()
    _read_open_file()


def _read_open_file() -> None:
    for scene in bpy.data.scenes:
        versions.upgrade(scene)
    _resolve_linked()
    _unpack(bpy.data.scenes)
    keep_missing(bpy.context)


@persistent
def _imported(context: bpy.types.BlendImportContext, *_: object) -> None:
    """Only what came in: scenes made here have the same number as files of before there was one."""
    own = Path(bpy.data.filepath).parent if bpy.data.filepath else None
    came = set(own_paths.blocks_with_settings())
    for item in context.import_items:
        if isinstance(item.id, bpy.types.Scene):
            versions.upgrade(item.id)
        if item.id in came and item.id.library is None and item.source_library is not None:
            library = Path(bpy.path.abspath(item.source_library.filepath))
            own_paths.follow((item.id,), library.parent, own)
    _resolve_linked()
    _unpack(scene for scene in bpy.data.scenes if scene in came)
    keep_missing(bpy.context)


def _unpack(scenes: Iterable[bpy.types.Scene]) -> None:
    """Packed probes whose folders are not there are to be had in this session."""
    for scene in scenes:
        if packed_names(scene):
            try:
                packed_probe.unpack_for_session(scene.spectral_probe)
            except (
                SpectralProbeError
            ) as problem:  # no room in the temporary folder: the buttons say what is missing
                _LOG.warning("%s", problem)


def _pack_again() -> None:
    for scene in bpy.data.scenes:
        if scene.library is None and packed_names(scene) and scene.spectral_probe.packed.outdated:
            settings = scene.spectral_probe
            try:
                packed_probe.pack(settings, built_folder(settings))
            except SpectralProbeError as problem:
                _LOG.warning("%s", problem)


def packed_names(scene: bpy.types.Scene) -> list[str]:
    """Files of a probe that a scene holds; looking makes no settings where there are none."""
    stored = versions.stored_settings(scene)
    return (
        []
        if stored is None or "packed" not in stored
        else [item.name for item in scene.spectral_probe.packed.files]
    )


def _resolve_linked() -> None:
    """Linked datablocks' paths are relative to their own file; they are read anew every time, so nothing of this is saved."""
    for block in own_paths.blocks_with_settings():
        if block.library is not None:
            own_paths.follow((block,), Path(bpy.path.abspath(block.library.filepath)).parent, None)


def _saving_handlers() -> tuple[tuple[str, Callable[..., None]], ...]:
    """Before and after a file is saved; what the one did is put back by the other where only a copy was saved."""
    put_back: list[Callable[[], None]] = []

    @persistent
    def before(filepath: str, *_: object) -> None:
        versions.stamp(bpy.data.scenes)
        _pack_again()
        put_back.clear()
        old, new = bpy.data.filepath, Path(filepath).parent
        if old and Path(old).parent != new:
            put_back.append(own_paths.follow(own_paths.local_blocks(), Path(old).parent, new))

    @persistent
    def after(filepath: str, *_: object) -> None:
        for undo in put_back:
            if bpy.data.filepath != filepath:
                undo()
        put_back.clear()

    return (("save_pre", before), ("save_post", after), ("save_post_fail", after))


def _ours(name: str) -> list[Callable[..., None]]:
    return [handler for handler in getattr(bpy.app.handlers, name) if handler.__module__ == __name__]


_LISTS = ("load_post", "blend_import_post", "save_pre", "save_post", "save_post_fail")


def register() -> None:
    """Follow files from now on, and the one that is open already."""
    _remove_handlers()
    for name, handler in (("load_post", _loaded), ("blend_import_post", _imported), *_saving_handlers()):
        getattr(bpy.app.handlers, name).append(handler)
    # While an extension is enabled the file cannot be reached; the timer runs once.
    bpy.app.timers.register(_read_open_file, first_interval=0.0)


def unregister() -> None:
    """Take the handlers back; scenes keep the number by which they are known when it is enabled again."""
    if bpy.app.timers.is_registered(_read_open_file):
        bpy.app.timers.unregister(_read_open_file)
    _remove_handlers()
    versions.stamp(getattr(bpy.data, "scenes", ()))  # none while Blender quits


def _remove_handlers() -> None:
    for name in _LISTS:
        for handler in _ours(name):
            getattr(bpy.app.handlers, name).remove(handler)
