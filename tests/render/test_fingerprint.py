"""The fingerprint: the same after saving and opening again, another after every visible change."""

import shutil

import bpy
import numpy as np
import pytest


@pytest.fixture
def digest(extension):
    return extension("operators.bridge.fingerprint").scene_fingerprint


@pytest.fixture
def furnished(scene, ball, tmp_path):
    """Objects of all sorts: modifiers, geometry nodes, hair, an instanced collection, a texture from a file, a lamp."""
    material = ball("ShaderNodeBsdfPrincipled")
    thing = bpy.context.object
    thing.name = "Ball"
    thing.modifiers.new("Waves", "WAVE")
    picture = bpy.data.images.new("Wood", 4, 4)
    picture.filepath_raw, picture.file_format = str(tmp_path / "wood.png"), "PNG"
    picture.save()
    texture = material.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = bpy.data.images.load(str(tmp_path / "wood.png"))
    material.node_tree.links.new(texture.outputs[0], material.node_tree.nodes["Shader"].inputs[0])
    hair = bpy.data.objects.new("Hair", bpy.data.hair_curves.new("Hair"))
    hair.data.add_curves([3, 4])
    scene.collection.objects.link(hair)
    group = bpy.data.collections.new("Group")
    group.objects.link(bpy.data.objects.new("Member", thing.data))
    instance = bpy.data.objects.new("Instance", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", group
    scene.collection.objects.link(instance)
    scene.collection.objects.link(bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "AREA")))
    scene.world = bpy.data.worlds.new("World")
    child = bpy.data.collections.new("Child")
    child.objects.link(bpy.data.objects.new("Child", thing.data))
    scene.collection.children.link(child)
    bpy.context.view_layer.update()
    return scene


def test_saved_and_opened_again(furnished, digest, tmp_path):
    before = digest(furnished)
    assert digest(furnished) == before
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    assert digest(bpy.context.scene) == before
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))
    assert digest(bpy.context.scene) == before


def shader():
    return bpy.data.materials["Material"].node_tree.nodes["Shader"]


def _move_a_vertex(_scene):
    bpy.data.objects["Ball"].data.vertices[0].co.x += 0.01


def _paint(_scene):
    image = bpy.data.images["wood.png"]
    image.pixels[0] = 0.5
    image.save()


def _move_hair(_scene):
    bpy.data.objects["Hair"].data.points[1].position = (1.0, 2.0, 3.0)


def _unlink(_scene):
    tree = bpy.data.materials["Material"].node_tree
    tree.links.remove(tree.nodes["Shader"].inputs[0].links[0])


VISIBLE = {
    "object moved": lambda s: setattr(s.objects["Ball"].location, "x", 1.0),
    "object hidden": lambda s: setattr(s.objects["Ball"], "hide_render", True),
    "vertex moved": _move_a_vertex,
    "modifier": lambda s: setattr(s.objects["Ball"].modifiers["Waves"], "height", 0.9),
    "modifier not rendered": lambda s: setattr(s.objects["Ball"].modifiers["Waves"], "show_render", False),
    "colour": lambda _: setattr(shader().inputs["Coat Tint"], "default_value", (1.0, 0.0, 0.0, 1.0)),
    "link": _unlink,
    "spectral kind": lambda _: setattr(bpy.data.materials["Material"].spectral_probe, "kind", "METAL"),
    "texture": _paint,
    "hair": _move_hair,
    "instance": lambda s: setattr(s.objects["Instance"].location, "z", 2.0),
    "lamp": lambda _: setattr(bpy.data.lights["Lamp"], "energy", 99.0),
    "lens": lambda s: setattr(s.camera.data, "lens", 85.0),
    "world": lambda s: setattr(
        s.world.node_tree.nodes["Background"].inputs["Strength"], "default_value", 3.0
    ),
    "resolution": lambda s: setattr(s.render, "resolution_x", 65),
    "bounces": lambda s: setattr(s.cycles, "max_bounces", 3),
    "seed": lambda s: setattr(s.cycles, "seed", 3),
    "film": lambda s: setattr(s.render, "film_transparent", True),
    "collection": lambda s: setattr(s.view_layers[0].layer_collection.children["Child"], "holdout", True),
    "frame": lambda s: s.frame_set(7),
}


@pytest.mark.parametrize("change", VISIBLE.values(), ids=VISIBLE.keys())
def test_a_visible_change(furnished, digest, change):
    before = digest(furnished)
    change(furnished)
    bpy.context.view_layer.update()
    assert digest(furnished) != before


INVISIBLE = {
    "selection": lambda s: s.objects["Ball"].select_set(False),
    "place of a node": lambda _: setattr(shader(), "location", (99.0, 1.0)),
    "size of a node": lambda _: setattr(shader(), "width", 333.0),
    "samples": lambda s: setattr(s.cycles, "samples", 77),
    "output path": lambda s: setattr(s.render, "filepath", "//elsewhere"),
    "results": lambda s: setattr(s.spectral_probe.render, "seconds", 3.0),
    "a datablock no one uses": lambda _: bpy.data.materials.new("Other"),
    "viewport": lambda s: setattr(s.objects["Ball"], "show_name", True),
}


@pytest.mark.parametrize("change", INVISIBLE.values(), ids=INVISIBLE.keys())
def test_an_invisible_change(furnished, digest, change):
    before = digest(furnished)
    change(furnished)
    bpy.context.view_layer.update()
    assert digest(furnished) == before


@pytest.mark.parametrize(("kind", "field"), [("METAL", "metal"), ("REFLECTANCE", "reflectance_path")])
def test_the_content_of_a_file_with_a_spectrum(furnished, digest, tmp_path, kind, field):
    table = tmp_path / "measured.csv"
    table.write_text("400,0.5,1\n700,0.5,1\n")
    settings = bpy.data.materials["Material"].spectral_probe
    settings.kind = kind
    setattr(settings, field, str(table))
    before = digest(furnished)
    table.write_text("400,0.5,1\n700,0.75,1\n")
    assert digest(furnished) != before


@pytest.mark.usefixtures("furnished")
def test_the_same_scene_elsewhere(digest, extension, tmp_path):
    """A folder with a scene, its texture and its table, copied under another path, with other times."""
    of_files = extension("operators.bridge.file_digest").opened_files_digest
    here, there = tmp_path / "here", tmp_path / "mount" / "there"
    here.mkdir()
    (tmp_path / "wood.png").rename(here / "wood.png")
    (here / "measured.csv").write_text("400,0.5,1\n700,0.5,1\n")
    settings = bpy.data.materials["Material"].spectral_probe
    settings.kind, settings.reflectance_path = "REFLECTANCE", "//measured.csv"
    bpy.data.images["wood.png"].filepath = "//wood.png"
    bpy.ops.wm.save_as_mainfile(filepath=str(here / "scene.blend"), relative_remap=False)
    shutil.copytree(here, there, copy_function=shutil.copyfile)
    digests = []
    for folder in (here, there):
        bpy.ops.wm.open_mainfile(filepath=str(folder / "scene.blend"))
        digests.append((digest(bpy.context.scene), of_files()))
    assert digests[0] == digests[1]
    for name in ("measured.csv", "wood.png"):
        content = (there / name).read_bytes()
        (there / name).write_bytes(content[:-2] + b"9" + content[-1:])
        assert digest(bpy.context.scene) != digests[0][0]
        assert of_files() != digests[0][1]
        (there / name).write_bytes(content)
    assert digest(bpy.context.scene) == digests[0][0]
    assert of_files() == digests[0][1]


def test_light(extension, uniform_light):
    digest = extension("operators.bridge.fingerprint").light_fingerprint
    ramp = np.linspace(1.0, 2.0, 61)
    assert digest(uniform_light(ramp)) == digest(uniform_light(ramp.copy()))
    assert digest(uniform_light(ramp)) != digest(uniform_light(ramp * 1.01))
