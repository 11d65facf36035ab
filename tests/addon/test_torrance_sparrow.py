"""The button that gives an object the paper's surface, and its panel."""

import math

import bpy
import pytest


@pytest.fixture
def cube(scene):
    scene.render.engine = "CYCLES"
    bpy.ops.mesh.primitive_cube_add()
    return bpy.context.object


def group_node(material):
    return next(node for node in material.node_tree.nodes if node.type == "GROUP")


def test_the_object_gets_what_the_function_makes(cube, in_extension):
    bpy.ops.spectral_probe.add_torrance_sparrow(
        metal="Cu", alpha=0.1, beta=3.0, beta_mirror=0.2, gamma_rad=0.3
    )
    material = cube.active_material
    assert (material.spectral_probe.kind, material.spectral_probe.metal) == ("METAL", "Cu")
    values = {s.name: s.default_value for s in group_node(material).inputs}
    assert [values[n] for n in ("Alpha", "Beta", "Beta Mirror", "Gamma")] == pytest.approx(
        [0.1, 3.0, 0.2, 0.3]
    )
    copper, _ = in_extension("operators.bridge.materials").metal_colours("Cu")
    assert list(values["Metal Color"])[:3] == pytest.approx(list(copper))


def test_the_group_is_made_once_and_the_active_slot_is_used(cube):
    bpy.ops.spectral_probe.add_torrance_sparrow()
    first = cube.active_material
    bpy.ops.spectral_probe.add_torrance_sparrow()
    assert len(cube.material_slots) == 1
    assert cube.active_material != first
    assert group_node(cube.active_material).node_tree == group_node(first).node_tree


@pytest.mark.usefixtures("scene")
def test_without_an_object_the_button_says_why():
    bpy.context.view_layer.objects.active = None
    with pytest.raises(RuntimeError, match="Select an object"):
        bpy.ops.spectral_probe.add_torrance_sparrow()


def test_an_unknown_metal_changes_nothing(cube):
    with pytest.raises(RuntimeError, match="There is no metal called"):
        bpy.ops.spectral_probe.add_torrance_sparrow(metal="Unobtainium")
    assert cube.active_material is None
    assert not bpy.data.node_groups


def test_the_panel_shows_the_parameters(cube, drawn):
    panel = bpy.types.SPECTRAL_PROBE_PT_torrance_sparrow
    assert [w["operator"] for w in drawn(panel, object=cube) if w.get("operator")]
    bpy.ops.spectral_probe.add_torrance_sparrow(gamma_rad=math.radians(15.0))
    shown = [w.get("draw_string", "") for w in drawn(panel, object=cube)]
    assert sum(any(name in text for text in shown) for name in ("Alpha", "Beta", "Gamma")) == 3


def test_the_groups_sockets_explain_themselves(cube):
    bpy.ops.spectral_probe.add_torrance_sparrow()
    sockets = group_node(cube.active_material).node_tree.interface.items_tree
    assert all(socket.description for socket in sockets if socket.in_out == "INPUT")


def test_gamma_goes_as_far_as_a_beckmann_lobe_follows(in_extension):
    widest_rad = in_extension("spectral_probe.render.beckmann").WIDEST_GAMMA_RAD
    gamma = bpy.ops.spectral_probe.add_torrance_sparrow.get_rna_type().properties["gamma_rad"]
    assert gamma.hard_max == pytest.approx(widest_rad)
