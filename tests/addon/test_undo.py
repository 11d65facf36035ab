"""Undo takes back all that a button changed, and redo brings exactly that again, for every operator."""

import json
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import bpy
import pytest

ops = bpy.ops.spectral_probe


def nothing(_settings, _folder):
    """No preparation."""


def a_region(settings, _folder):
    settings.region.kind, settings.region.azimuth, settings.region.elevation = "SEED", 0.0, math.radians(30)


def an_edit(settings, folder):
    a_region(settings, folder)
    ops.light_world(normalise=False)
    ops.add_glass()


def packed(settings, folder):
    an_edit(settings, folder)
    ops.pack_probe()


def own_world(settings, _folder):
    settings.light, settings.rgb_twin = "WORLD", False
    settings.samples, settings.plan, settings.passes = 1, "NUMBER", 1
    scene = bpy.context.scene
    scene.render.engine, scene.render.resolution_x, scene.render.resolution_y = "CYCLES", 8, 8


def an_object(*_):
    bpy.ops.mesh.primitive_cube_add()


def lists(settings, _folder):
    settings.known_light.own_lights.add().path = "//lamp.csv"
    settings.known_light.regions.add().name = "Region 1"
    settings.swap.items.add().name = "window"


def moved_photo(settings, folder):
    (folder / "found").mkdir()
    (folder / "found" / "v7.dng").touch()
    settings.views.add().photos.add().path = str(folder / "gone" / "v7.dng")


@dataclass(frozen=True)
class Case:
    """How an operator is called so that it changes something: what comes first, and its properties."""

    before: Callable = nothing
    words: dict = field(default_factory=dict)
    files: Callable = lambda folder: {}  # noqa: ARG005  (properties that name files)


def photo(folder):
    return {"directory": str(folder), "files": [{"name": "view_0.exr"}]}


def lamp(folder):
    (folder / "lamp.csv").write_text("wavelength_nm,power\n400,1\n700,2\n")
    return {"directory": str(folder), "files": [{"name": "lamp.csv"}]}


def captured(settings, folder):
    ops.import_capture(filepath=str(folder / "capture.toml"))
    settings.probe_width = 64
    settings.probe_directory = str(folder / "built")


def one_photo(settings, folder):
    settings.views.add().photos.add().path = str(folder / "view_1.exr")


def two_photos(settings, folder):
    for _ in range(2):
        view = settings.views.add()
        view.photos.add().path = str(folder / "view_0.exr")
        view.photos.add().path = str(folder / "view_1.exr")


CASES = {
    "add_photos": Case(one_photo, files=photo),
    "choose_glass": Case(a_region, {"glass": "green"}),
    "draw_region": Case(words={"corners": "10 0, 30 0, 30 20"}),
    "import_photographs": Case(files=photo),
    "join_views": Case(two_photos, {"other": "AFTER"}),
    "move_photo": Case(two_photos, {"view": 2}),
    "pick_direction": Case(words={"azimuth": 0.5, "elevation": 0.25}),
    "remove_photo": Case(two_photos),
    "show_panorama": Case(),
    "show_photograph": Case(captured),
    "spread_views": Case(two_photos),
    "add_glass": Case(a_region),
    "add_ground": Case(lambda settings, _: setattr(settings.backplate, "ground_source", "GIVEN")),
    "add_mask": Case(),
    "add_object": Case(words={"kind": "SILVER_BALL"}),
    "add_own_light": Case(files=lamp),
    "add_region_light": Case(),
    "add_swappable": Case(a_region),
    "add_torrance_sparrow": Case(an_object),
    "add_view": Case(files=photo),
    "build_probe": Case(captured),
    "choose_spectrum": Case(an_object, {"kind": "METAL", "entry": "Cu"}),
    "detect_ball": Case(captured),
    "find_files": Case(moved_photo, files=lambda folder: {"directory": str(folder / "found")}),
    "import_capture": Case(files=lambda folder: {"filepath": str(folder / "capture.toml")}),
    "light_from_photographs": Case(captured),
    "light_world": Case(words={"normalise": False}),
    "make_paths": Case(words={"form": "ABSOLUTE"}),
    "own_render_folder": Case(),
    "pack_probe": Case(an_edit),
    "plan_render": Case(own_world),
    "remove_edit": Case(an_edit),
    "remove_own_light": Case(lists),
    "remove_region_light": Case(lists),
    "remove_swappable": Case(lists),
    "remove_view": Case(lambda settings, _: settings.views.add()),
    "render_spectral": Case(own_world),
    "replace_lamp": Case(a_region),
    "save_capture": Case(captured, files=lambda folder: {"filepath": str(folder / "again.toml")}),
    "seed_from_view": Case(words={"target": "EDIT"}),
    "show_confidence": Case(),
    "show_spectrum": Case(),
    "unpack_probe": Case(packed),
    "use_cycles": Case(),
}

NOT_WALKED = {
    "add_asset_library": "changes the preferences, not the file",
    "copy_report": "fills the clipboard",
    "remove_asset_library": "changes the preferences, not the file",
    "render_and_compare": "as render_spectral, and keeps numbers as show_spectrum does",
    "calibrate": "needs photographs of a board; sets fields as import_capture does",
    "choose_lamp": "as choose_glass",
    "edit_outline": "a tool of the window: tests/window walks it",
    "edit_region": "a tool of the window: tests/window walks it",
    "load_preset": "sets fields as import_capture does",
    "save_preset": "changes a file of the user's, not the scene",
    "compare": "needs a render; keeps numbers as show_spectrum does",
    "composite": "needs a render; keeps numbers as show_spectrum does",
    "match_backplate": "needs real photographs",
    "render_animation": "as render_spectral",
    "export_farm_job": "writes files, nothing of the scene",
    "show_basis": "as show_spectrum",
    "show_comparison": "shows a picture of a comparison",
    "show_sensitivities": "changes no settings",
    "show_swatches": "changes no data of the file",
    "swap_light": "needs a render; keeps lights as render_spectral does",
}
"""Operators that this test leaves out, and why."""


def plain(value):
    """Stored settings as JSON: datablocks by name; empty groups, which reading makes, left out."""
    if isinstance(value, bpy.types.ID):
        return f"{type(value).__name__} {value.name}"
    if hasattr(value, "items"):
        return {key: told for key, part in value.items() if (told := plain(part)) not in ({}, [])}
    if isinstance(value, list) or hasattr(value, "to_list"):
        return [plain(part) for part in value]
    return value


def state(versions):
    """All that our operators change: settings, and which datablocks there are."""
    scene = bpy.context.scene
    owners = [*bpy.data.scenes, *bpy.data.materials, *bpy.data.lights]
    images = [image for image in bpy.data.images if image.type != "RENDER_RESULT"]
    return json.dumps(
        {
            "settings": {
                f"{type(owner).__name__} {owner.name}": plain(versions.stored_settings(owner) or {})
                for owner in owners
            },
            "objects": sorted(thing.name for thing in scene.objects),
            "images": sorted((image.name, image.filepath) for image in images),
            "worlds": sorted(world.name for world in bpy.data.worlds),
            "world": scene.world and scene.world.name,
            "materials": sorted(material.name for material in bpy.data.materials),
            "render": [scene.render.engine, scene.render.resolution_x, scene.camera and scene.camera.name],
        },
        indent=1,
        sort_keys=True,
        default=str,
    )


@pytest.fixture
def project(tmp_path, scene, write_small_probe, capture_file):
    write_small_probe(tmp_path / "probe")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    scene.spectral_probe.probe_directory = "//probe/"
    return capture_file.parent


@pytest.mark.parametrize("name", CASES)
def test_undo_and_redo(name, project, in_extension):
    case, versions = CASES[name], in_extension("versions")
    case.before(bpy.context.scene.spectral_probe, project)
    words = case.words | case.files(project)
    bpy.ops.ed.undo_push(message="before")
    before = state(versions)
    assert getattr(ops, name)("EXEC_DEFAULT", True, **words) == {"FINISHED"}  # True: undo as from the window
    after = state(versions)
    assert after != before, "the case shows nothing: the operator changed nothing"
    bpy.ops.ed.undo()
    assert state(versions) == before
    bpy.ops.ed.redo()
    assert state(versions) == after


def test_every_operator_is_walked_or_said_why_not():
    registered = {
        name.removeprefix("SPECTRAL_PROBE_OT_")
        for name in dir(bpy.types)
        if name.startswith("SPECTRAL_PROBE_OT_")
    }
    assert not CASES.keys() & NOT_WALKED.keys()
    left = registered - CASES.keys() - NOT_WALKED.keys()
    assert not left, f"Give each a case in CASES, or a reason in NOT_WALKED: {sorted(left)}"


def test_undo_of_a_glass_lights_the_world_as_before(project):
    a_region(bpy.context.scene.spectral_probe, project)
    ops.light_world(normalise=False)
    bpy.ops.ed.undo_push(message="before")
    shown = lambda: next(  # noqa: E731  (three times the same)
        Path(bpy.path.abspath(node.image.filepath))
        for node in bpy.context.scene.world.node_tree.nodes
        if node.type == "TEX_ENVIRONMENT"
    )
    assert shown() == project / "probe" / "world.exr"
    ops.add_glass("EXEC_DEFAULT", True)
    assert shown().parent.parent.name == "edits"
    bpy.ops.ed.undo()
    assert shown() == project / "probe" / "world.exr"
    bpy.ops.ed.redo()
    assert shown().parent.parent.name == "edits"
    assert shown().is_file()
