"""What adding the metals does to Blender's start-up scene, and to one that somebody has touched."""

import bpy
import pytest


@pytest.fixture
def startup():
    """Blender's start-up scene."""
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    yield bpy.context.scene
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def test_the_metals_replace_cube_and_lamp_and_are_seen(startup, capfd):
    from bpy_extras.object_utils import world_to_camera_view

    bpy.ops.spectral_probe.add_object(kind="GROUP")
    assert {thing.type for thing in startup.objects} == {"MESH", "CAMERA"}
    assert "Removed from the start-up scene: Cube, Light" in capfd.readouterr().out
    bpy.context.view_layer.update()
    for thing in startup.objects:
        if thing.type == "MESH":
            seen = world_to_camera_view(startup, startup.camera, thing.matrix_world.translation)
            assert 0 < seen.x < 1, thing.name
            assert 0 < seen.y < 1, thing.name
            assert 0.5 < seen.z < 3, thing.name


def test_what_was_touched_stays(startup):
    startup.objects["Cube"].location.x = 0.5
    startup.objects["Light"].data.energy = 50.0
    startup.camera.location.z = 3.0
    bpy.ops.spectral_probe.add_object(kind="GROUP")
    assert {"Cube", "Light", "Camera"} <= {thing.name for thing in startup.objects}
    assert startup.camera.location.z == 3.0


@pytest.mark.parametrize("words", [{"kind": "GROUP", "replace_startup": False}, {"kind": "COPPER_BALL"}])
def test_nothing_is_replaced_unasked(startup, words):
    bpy.ops.spectral_probe.add_object(**words)
    assert {"Cube", "Light", "Camera"} <= {thing.name for thing in startup.objects}
    assert startup.camera.location.x > 7
