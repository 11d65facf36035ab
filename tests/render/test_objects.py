"""The objects of fig. 12: sound bodies with spectral materials."""

import bmesh
import bpy
import numpy as np
import pytest


@pytest.fixture
def objects(extension):
    return extension("operators.bridge.objects")


def test_the_demo_scene_stands_on_its_table(scene, objects):
    objects.demo_scene(scene)
    bpy.context.view_layer.update()
    kinds = {m.name: (m.spectral_probe.kind, m.spectral_probe.metal) for m in bpy.data.materials}
    assert kinds["Gold"] == ("METAL", "Au")
    assert kinds["Silver"] == ("METAL", "Ag")
    assert kinds["Copper"] == ("METAL", "Cu")

    def extent(name):
        thing = bpy.data.objects[name]
        corners = np.array([thing.matrix_world @ v.co for v in thing.data.vertices])
        return corners.min(0), corners.max(0)

    pedestal, silver, copper, table = (
        extent(name) for name in ("Gold Pedestal", "Silver Ball", "Copper Ball", "Table")
    )
    assert pedestal[0][2] == copper[0][2] == pytest.approx(table[1][2], abs=1e-6)
    assert silver[0][2] == pytest.approx(pedestal[1][2], abs=1e-6)
    assert np.ptp(silver, axis=0)[2] < np.ptp(copper, axis=0)[2] < np.ptp(pedestal, axis=0)[2]
    assert copper[0][0] > pedestal[1][0]  # beside it, not in it


def test_a_group_is_as_large_as_the_ball_it_stands_for_and_turns_with_the_gaze(scene, objects):
    at, radius_m = np.array([0.3, -0.2, 1.1]), 0.05
    scale = objects.scale_beside_ball(radius_m)
    pedestal, silver, copper = objects.add_metals(scene.collection, at, 90.0, scale)
    bpy.context.view_layer.update()
    np.testing.assert_allclose(copper.dimensions, 2 * radius_m, rtol=1e-3)
    assert pedestal.dimensions.z == pytest.approx(0.5 * scale)
    assert silver.location.z == pytest.approx(at[2] + 0.5 * scale)
    assert all(tuple(thing.scale) == (1.0, 1.0, 1.0) for thing in (pedestal, silver, copper))
    assert pedestal.location.y > at[1] > copper.location.y  # looking along +X, the left hand is at +Y
    assert copper.location.x < at[0] < pedestal.location.x  # and the copper ball is nearer


@pytest.mark.parametrize("name", ["add_gold_pedestal", "add_silver_ball", "add_copper_ball", "add_table"])
def test_bodies_are_closed_and_face_outwards(scene, objects, name):
    thing = getattr(objects, name)(scene.collection)
    body = bmesh.new()
    body.from_mesh(thing.data)
    assert all(edge.is_manifold for edge in body.edges)
    assert body.calc_volume(signed=True) > 0
    assert all(face.calc_area() > 1e-12 for face in body.faces)
    assert all(polygon.use_smooth for polygon in thing.data.polygons)
    body.free()


def test_materials_are_used_again(scene, objects):
    first, second = objects.add_copper_ball(scene.collection), objects.add_copper_ball(scene.collection)
    assert first.data.materials[0] == second.data.materials[0]
    first.data.materials[0].spectral_probe.metal = "Fe"  # now somebody else's
    assert objects.add_copper_ball(scene.collection).data.materials[0] != first.data.materials[0]


def test_gold_is_yellow_and_copper_red_in_ordinary_renders(scene, objects):
    colours = {}
    for add in (objects.add_gold_pedestal, objects.add_copper_ball, objects.add_silver_ball):
        material = add(scene.collection).data.materials[0]
        shader = next(n for n in material.node_tree.nodes if n.type == "BSDF_METALLIC")
        colours[material.name] = np.array(shader.inputs["Base Color"].default_value[:3])
    assert colours["Gold"][0] > colours["Gold"][1] > 2 * colours["Gold"][2]
    assert colours["Copper"][0] > 1.2 * colours["Copper"][1] > colours["Copper"][2]
    assert np.ptp(colours["Silver"]) < 0.1
