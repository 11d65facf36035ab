"""Which pixels show which object, in a scene of a ball, a ground and instances."""

import bpy
import numpy as np
import pytest

NAME = 'Bäll "1\\2"'


@pytest.fixture
def furnished(scene, ball):
    """A ball in front of a wall that is a catcher, cubes that only instances show, and a holdout."""
    scene.render.resolution_x = scene.render.resolution_y = 32
    ball()
    bpy.context.object.name = NAME
    add("Wall", (0.0, 6.0, -3.5), 3.0).is_shadow_catcher = True
    cube = add("Cube", (0.0, 0.0, 0.0), 0.25)
    shown = bpy.data.collections.new("Shown")
    scene.collection.objects.unlink(cube)
    shown.objects.link(cube)
    for name, x in (("Left", -1.5), ("Right", 1.5)):
        instance = bpy.data.objects.new(name, None)
        instance.instance_type, instance.instance_collection = "COLLECTION", shown
        instance.location = (x, 0.0, 1.4)
        scene.collection.objects.link(instance)
    add("Post", (0.7, -2.0, -0.7), 0.2).is_holdout = True
    return scene


def add(name, location, half):
    bpy.ops.mesh.primitive_cube_add(size=2 * half, location=location)
    bpy.context.object.name = name
    return bpy.context.object


def test_shares_add_up_and_edges_are_shared(furnished, extension):
    found = extension("operators.bridge.object_coverage").object_coverage(furnished, 64)
    assert found.objects.keys() == {NAME, "Cube"}
    np.testing.assert_allclose(sum(found.objects.values()), found.coverage, atol=1e-5)
    assert found.coverage[16, 16] == 1.0
    assert found.ground[20, 16] == 0.0  # behind the ball
    assert found.ground[28, 3] > 0.9
    assert (found.coverage + found.ground).max() <= 1.0
    assert found.coverage[0, 16] == found.ground[0, 16] == 0.0  # nothing there
    cubes = found.objects["Cube"]
    assert cubes[:, :16].sum() == pytest.approx(cubes[:, 16:].sum(), rel=0.02)
    edge = (found.coverage > 0.0) & (found.coverage < 1.0) & (found.ground > 0.0)
    assert edge.sum() > 10
    post = (found.coverage[25:28, 25:28] + found.ground[25:28, 25:28]).max()
    assert post == 0.0  # a holdout is neither


def test_the_disc_has_the_area_that_geometry_says(furnished, extension):
    """A ball of radius 1 at distance 5 is seen under asin(1/5)."""
    found = extension("operators.bridge.object_coverage").object_coverage(furnished, 128)
    camera = furnished.camera.data
    focal_px = camera.lens / camera.sensor_width * 32
    radius_px = focal_px * np.tan(np.arcsin(0.2))
    assert found.objects[NAME].sum() == pytest.approx(np.pi * radius_px**2, rel=0.01)


def test_what_instances_a_catcher_decides_too(furnished, extension):
    surfaces = extension("operators.bridge.catchers").surfaces
    names = [
        {thing.name for thing in kind} for kind in (surfaces(furnished).catchers, surfaces(furnished).virtual)
    ]
    assert names == [{"Wall"}, {NAME, "Cube"}]
    furnished.objects["Left"].is_shadow_catcher = True
    assert "Cube" in {thing.name for thing in surfaces(furnished).virtual}  # the right one is not
    furnished.objects["Right"].is_shadow_catcher = True
    assert {thing.name for thing in surfaces(furnished).catchers} == {"Wall", "Cube"}


def test_doubtful_scenes_are_told(furnished, extension):
    surfaces = extension("operators.bridge.catchers").surfaces
    assert surfaces(furnished).warnings == ()
    furnished.objects["Wall"].hide_render = True
    found = surfaces(furnished)
    assert found.catchers == ()
    assert any('"Wall" is hidden' in text for text in found.warnings)
    furnished.objects["Wall"].hide_render = False
    for name in (NAME, "Left", "Right"):
        furnished.objects[name].is_shadow_catcher = True
    assert any("nothing virtual" in text for text in surfaces(furnished).warnings)
