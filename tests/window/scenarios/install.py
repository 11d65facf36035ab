"""The zip is installed in a clean Blender by what Preferences > Get Extensions > Install from Disk calls."""

import bpy

MODULE = "bl_ext.user_default.spectral_probe"


def steps(ui):
    """Install, enable, keep the preferences."""
    with ui.step("install"):
        ui.operator(
            "extensions.package_install_files",
            "EXEC_DEFAULT",
            filepath=ui.words[0],
            repo="user_default",
            enable_on_install=True,
        )
        yield from ui.wait(lambda: MODULE in bpy.context.preferences.addons, 120, "the extension's entry")
        yield 0.5
    ui.results["enabled"] = MODULE in bpy.context.preferences.addons
    yield from ui.sidebar("VIEW_3D")
    ui.shot("installed")
    bpy.ops.wm.save_userpref()
