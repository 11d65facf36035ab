"""What is known of the files of ours while a .blend is open: `WindowManager.spectral_probe_files`."""

import bpy
from bpy.props import PointerProperty, StringProperty


class SPECTRAL_PROBE_PG_files(bpy.types.PropertyGroup):
    """Files that were missing; not saved."""

    missing: StringProperty(
        name="Missing", description="Files that were not where they should be, one a line"
    )


_register_classes, _unregister_classes = bpy.utils.register_classes_factory((SPECTRAL_PROBE_PG_files,))


def register() -> None:
    """Attach it to the window manager."""
    _register_classes()
    bpy.types.WindowManager.spectral_probe_files = PointerProperty(
        type=SPECTRAL_PROBE_PG_files, options={"SKIP_SAVE"}
    )


def unregister() -> None:
    """Detach it."""
    del bpy.types.WindowManager.spectral_probe_files
    _unregister_classes()
