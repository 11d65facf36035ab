"""The scene comes back exactly: after success, after an error in mid-render, and after the job is closed early."""

import bpy
import numpy as np
import pytest

# What Blender itself changes by rendering, or what only says when something was changed.
VOLATILE = {
    "rna_type",
    "bl_rna",
    "is_evaluated",
    "tag",
    "session_uid",
    "depsgraph",
    "preview",
    "original",
    "is_updated",
}

FLAGS = (
    "lightgroup",
    "is_shadow_catcher",
    "hide_render",
    *(
        f"visible_{ray}"
        for ray in ("camera", "diffuse", "glossy", "transmission", "volume_scatter", "shadow")
    ),
)
"""Of objects: what puts them into a render's parts and light groups."""


def dump(owner, depth=0, seen=None):
    """All readable RNA properties of a structure, recursively; datablocks by type, name and address."""
    seen = set() if seen is None else seen
    found = {}
    for prop in owner.bl_rna.properties:
        if prop.identifier in VOLATILE:
            continue
        if prop.identifier == "use_nodes":
            continue  # reading it warns: Blender 6 will not have it
        value = getattr(owner, prop.identifier)
        found[prop.identifier] = plain(value, prop, depth, seen)
    return found


def plain(value, prop, depth, seen):
    if prop.type == "COLLECTION":
        return [item(v, depth, seen) for v in value]
    if prop.type == "POINTER":
        return None if value is None else item(value, depth, seen)
    if hasattr(value, "__len__") and not isinstance(value, str | set):
        return np.array(value).tolist()
    return value


def item(value, depth, seen):
    identity = (type(value).__name__, getattr(value, "name", ""), value.as_pointer())
    owned = not isinstance(value, bpy.types.ID) or value.is_embedded_data
    if not owned or depth > 6 or identity in seen:
        return identity
    return identity, dump(value, depth + 1, seen | {identity})


def everything(scene):
    materials = [dump(m) for m in bpy.data.materials]
    objects = [
        [(s.name, s.link, s.material.as_pointer() if s.material else 0) for s in o.material_slots]
        for o in scene.objects
    ]
    data = [(type(o.data).__name__, o.data.as_pointer()) if o.data else None for o in scene.objects]
    return {
        # Blender counts a scene's users once too often for every Render Layers node made, and anew on opening a file.
        "scene": {**dump(scene), "users": None},
        "world": dump(scene.world) if scene.world else None,
        "materials": materials,
        "groups": [dump(g) for g in bpy.data.node_groups],
        "lamps": [dump(lamp) for lamp in bpy.data.lights],
        "flags": [[getattr(thing, name) for name in FLAGS] for thing in scene.objects],
        "objects": objects,
        "data": data,
        "datablocks": sorted(
            (type(d).__name__, d.name, None if d == scene else d.users)
            for collection in collections()
            for d in collection
        ),
    }


def differences(before, after, path=""):
    """Where two dumps differ, as readable lines."""
    if isinstance(before, dict) and isinstance(after, dict) and before.keys() == after.keys():
        return [line for key in before for line in differences(before[key], after[key], f"{path}.{key}")]
    if isinstance(before, list | tuple) and isinstance(after, list | tuple) and len(before) == len(after):
        pairs = enumerate(zip(before, after, strict=True))
        return [line for number, pair in pairs for line in differences(*pair, f"{path}[{number}]")]
    return [] if before == after else [f"{path}: {str(before)[:200]} became {str(after)[:200]}"]


def collections():
    return [
        getattr(bpy.data, p.identifier)
        for p in bpy.data.bl_rna.properties
        if p.type == "COLLECTION" and p.identifier != "libraries"
    ]


@pytest.fixture
def furnished(scene, ball):
    """A scene with all that is swapped: shared and object-level materials, groups, links, animation, a lamp, a world."""
    scene.cycles.samples = 7
    scene.world = bpy.data.worlds.new("Own")
    textured = ball("ShaderNodeBsdfPrincipled")
    tree = textured.node_tree
    checker = tree.nodes.new("ShaderNodeTexChecker")
    tree.links.new(checker.outputs["Color"], tree.nodes["Shader"].inputs["Base Color"])
    tree.nodes["Shader"].inputs["Coat Tint"].keyframe_insert("default_value", frame=1)
    first = bpy.context.object
    metal = ball("ShaderNodeBsdfGlossy", (1.0, 1.0, 0.0))
    metal.spectral_probe.kind, metal.spectral_probe.metal = "METAL", "Cu"
    second = bpy.context.object
    shared = bpy.data.objects.new("Shared mesh", first.data)
    scene.collection.objects.link(shared)
    shared.material_slots[0].link = "OBJECT"
    shared.material_slots[0].material = metal
    second.data.materials.append(None)
    second.is_shadow_catcher, second.visible_glossy = True, False
    first.visible_shadow = False

    group = bpy.data.node_groups.new("Group", "ShaderNodeTree")
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    inner, output = group.nodes.new("ShaderNodeEmission"), group.nodes.new("NodeGroupOutput")
    group.links.new(inner.outputs[0], output.inputs[0])
    grouped = bpy.data.materials.new("Grouped")
    node = grouped.node_tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    surface = next(n for n in grouped.node_tree.nodes if n.type == "OUTPUT_MATERIAL").inputs["Surface"]
    grouped.node_tree.links.new(node.outputs[0], surface)
    second.data.materials.append(grouped)

    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "AREA"))
    scene.collection.objects.link(lamp)
    lamp.data.use_temperature, lamp.data.temperature = True, 3100.0
    lamp.data.color = (0.9, 0.5, 0.3)
    for name in ("Own", "emission"):  # one of the passes' own names, too
        scene.view_layers[0].lightgroups.add(name=name)
    scene.view_layers[0].active_lightgroup_index = 0
    lamp.lightgroup, first.lightgroup = "Own", "emission"
    scene.view_layers[0].material_override = None
    scene.view_layers.new("Other")
    bpy.context.view_layer.update()
    return scene


def test_the_comparison_would_see_a_change(furnished):
    """Each of these must show, or the tests below prove nothing."""
    changes = [
        lambda: setattr(furnished.cycles, "samples", 8),
        lambda: setattr(furnished.cycles, "sample_clamp_indirect", 0.0),
        lambda: setattr(furnished.render, "use_persistent_data", True),
        lambda: setattr(furnished.render.image_settings, "file_format", "OPEN_EXR"),
        lambda: setattr(furnished.view_layers[1], "use", False),
        lambda: setattr(furnished.objects["Shared mesh"].material_slots[0], "material", None),
        lambda: setattr(
            bpy.data.materials["Material"].node_tree.nodes["Shader"].inputs[1], "default_value", 0.123
        ),
        lambda: bpy.data.lights.new("Left over", "POINT"),
        lambda: setattr(furnished.objects["Lamp"], "lightgroup", ""),
        lambda: furnished.view_layers[0].lightgroups.remove(furnished.view_layers[0].lightgroups["Own"]),
        lambda: setattr(bpy.data.lights["Lamp"], "temperature", 2000.0),
        lambda: setattr(furnished, "world", None),
        lambda: setattr(furnished.objects["Shared mesh"], "visible_camera", False),
        lambda: setattr(furnished.render, "film_transparent", True),
    ]
    before = everything(furnished)
    for change in changes:
        change()
        after = everything(furnished)
        assert after != before
        before = after


@pytest.mark.parametrize("passes", [3, "all"])
def test_after_success(furnished, bridge, extension, uniform_light, tmp_path, passes):
    before = everything(furnished)
    job = bridge.spectral_render(
        furnished, uniform_light(np.ones(61)), None, tmp_path, samples=1, passes=passes, rgb_twin=passes == 3
    )
    result = extension("spectral_probe.model").finish(job)
    assert differences(before, everything(furnished)) == []
    assert [layer.name for layer in furnished.view_layers] == list(result.layers)


def test_after_an_error_in_mid_render(
    furnished, bridge, extension, uniform_light, go_on, tmp_path, monkeypatch
):
    before = everything(furnished)
    job = bridge.spectral_render(furnished, uniform_light(np.ones(61)), None, tmp_path, samples=1, passes=3)
    go_on(job, 3)
    rendering = extension("operators.bridge.step_rendering")
    monkeypatch.setattr(rendering, "sequence_samples", None)  # an error no one foresaw
    with pytest.raises(TypeError):
        for _ in job:
            pass
    assert differences(before, everything(furnished)) == []


@pytest.mark.parametrize("steps", [1, 3, 6])  # the last in the part without the objects
def test_after_closing_early(furnished, bridge, uniform_light, go_on, tmp_path, steps):
    before = everything(furnished)
    job = bridge.spectral_render(furnished, uniform_light(np.ones(61)), None, tmp_path, samples=1, passes=3)
    go_on(job, steps)
    job.close()
    assert differences(before, everything(furnished)) == []
    assert not (tmp_path / "image.exr").exists()


REMOVALS = {
    "object": lambda scene: bpy.data.objects.remove(scene.objects["Shared mesh"]),
    "camera": lambda scene: bpy.data.objects.remove(scene.camera),
    "world": lambda scene: bpy.data.worlds.remove(scene.world),
    "materials": lambda _: bpy.data.batch_remove(bpy.data.materials),
    "groups": lambda _: bpy.data.batch_remove(bpy.data.node_groups),
    "layer": lambda scene: scene.view_layers.remove(scene.view_layers["Other"]),
}


@pytest.mark.parametrize(
    ("removed", "passes"), [*((removed, 3) for removed in REMOVALS), ("materials", "all"), ("layer", "all")]
)
def test_what_is_removed_meanwhile_ends_the_render(
    furnished, bridge, extension, uniform_light, tmp_path, removed, passes
):
    before = {
        kind: set(getattr(bpy.data, kind).keys()) for kind in ("materials", "worlds", "lights", "images")
    }
    job = bridge.spectral_render(
        furnished, uniform_light(np.ones(61)), None, tmp_path, samples=1, passes=passes
    )
    while not next(job).message.startswith("Pass 1 "):
        pass
    REMOVALS[removed](furnished)
    error = extension("spectral_probe.errors").RenderError
    with pytest.raises(error, match="was changed while it was rendered"):
        for _ in job:
            pass
    for kind, names in before.items():
        assert set(getattr(bpy.data, kind).keys()) <= names
    assert not [group.name for group in bpy.data.node_groups if group.name.startswith("Spectral Probe")]


@pytest.mark.parametrize("one_wavelength", [True, False])
def test_after_lamps_went_on_and_off(furnished, extension, one_wavelength):
    materials = extension("operators.bridge.materials")
    before = everything(furnished)
    with materials.spectral_materials(furnished, one_wavelength=one_wavelength, level=0.02) as translated:
        names = [group.name for group in translated.emission]
        assert names == (["emission", "lamps 1"] if one_wavelength else [])
        for on in (False, True, False):
            translated.shine(on)
            translated.set_wavelengths(np.array([450.0, 550.0, 650.0]))
        assert everything(furnished) != before
    assert everything(furnished) == before
    with materials.rgb_materials(furnished):
        pass
    assert everything(furnished) == before
