"""The plate's operators and verb: what the core matched is in the scene, and bad input is one sentence."""

import json
from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import bpy
import numpy as np
import pytest

type Importer = Callable[[str], ModuleType]

SIZE = (64, 48)


@pytest.fixture
def probe(tmp_path: Path, in_extension: Importer) -> Path:
    """A probe of even light, and a view of EXR pictures that looks down by 20 degrees at a ball 0.8 m away."""
    model, grid = in_extension("spectral_probe.model"), in_extension("spectral_probe.spectra.grid")
    views = in_extension("spectral_probe.composite.probe_views")
    write_rgb = in_extension("spectral_probe.files.image_exr").write_rgb
    panorama = model.SpectralPanorama(
        weights=np.ones((16, 32, 1), np.float32),
        bases=np.full((1, 1, 61), 0.01),
        basis_index=np.zeros((16, 32), np.uint8),
        wavelengths_nm=grid.WAVELENGTHS_NM,
        valid=np.ones((16, 32), bool),
        confidence=np.ones((16, 32), np.float32),
    )
    in_extension("spectral_probe.files.probe_exr").write_probe(tmp_path / "probe.exr", panorama)
    write_rgb(tmp_path / "world.exr", np.full((16, 32, 3), 0.5, np.float32))
    write_rgb(tmp_path / "plate.exr", np.full((48, 64, 3), 0.3, np.float32))
    write_rgb(tmp_path / "small.exr", np.full((20, 64, 3), 0.3, np.float32))
    view = views.ProbeView(
        photos=(tmp_path / "plate.exr",),
        camera=model.Camera((80.0, 80.0), (33.0, 22.0), SIZE),
        half_size=False,
        rotation=in_extension("spectral_probe.geometry.frames").camera_to_world(0.0, 20.0),
        ball_centre_m=np.array([0.0, 0.05, 0.8]),
        ball_radius_m=0.06,
        outline_px=(33.0, 27.0, 6.0),
        shifts_px=np.zeros((1, 2)),
        exposures=(1.0,),
        converted=False,
        response_log_gain=None,
        gain=np.ones(3),
        camera_model="Rec.709",
        sensitivities=None,
    )
    table = {"views": [{views.MATCHING_KEY: views.view_table(view, tmp_path)}]}
    (tmp_path / "report.json").write_text(json.dumps(table))
    return tmp_path


@pytest.fixture
def ready(settings: Any, probe: Path) -> Any:
    settings.probe_directory = str(probe)
    settings.backplate.plate = str(probe / "plate.exr")
    return settings


def test_the_operator_sets_up_what_the_core_matched(
    ready: Any, probe: Path, scene: Any, in_extension: Importer
) -> None:
    prepare = in_extension("spectral_probe.composite.prepare")
    settings = in_extension("spectral_probe.composite.matching").MatchSettings(ground_below_m=0.1)
    finish = in_extension("spectral_probe.model").finish
    expected = finish(prepare.prepare_plate(probe, probe / "plate.exr", settings))
    ready.backplate.on_ground, ready.backplate.ground_below = False, 0.1
    assert bpy.ops.spectral_probe.match_backplate() == {"FINISHED"}
    bpy.context.view_layer.update()
    found = in_extension("operators.bridge.backplate").scene_backplate(scene)
    assert found.camera == expected.match.backplate.camera
    np.testing.assert_allclose(found.position_m, expected.match.backplate.position_m)
    assert (scene.render.resolution_x, scene.render.resolution_y) == SIZE
    assert [thing.name for thing in scene.objects if thing.type == "MESH" and thing.is_shadow_catcher] == [
        "Ground"
    ]
    np.testing.assert_allclose(ready.backplate.ground_mean, expected.ground_mean, rtol=1e-5)


@pytest.mark.usefixtures("ready")
def test_an_object_added_to_a_plate_is_as_large_as_the_ball_was() -> None:
    bpy.ops.spectral_probe.match_backplate()
    bpy.ops.spectral_probe.add_object(kind="COPPER_BALL")
    assert bpy.context.object.dimensions.z == pytest.approx(0.12, rel=1e-3)
    bpy.ops.spectral_probe.add_object(kind="COPPER_BALL", size=1.0)
    assert bpy.context.object.dimensions.z == pytest.approx(0.34, rel=1e-3)


@pytest.mark.usefixtures("ready")
def test_a_quick_look_at_part_of_the_resolution_lies_on_the_plate(
    probe: Path, scene: Any, in_extension: Importer
) -> None:
    bpy.ops.spectral_probe.match_backplate()
    bpy.context.view_layer.update()
    scene.render.resolution_percentage = 25
    bridge = in_extension("operators.bridge.backplate")
    table = in_extension("spectral_probe.composite.backplate_file").backplate_table
    whole, cut = (table(one, probe) for one in bridge.backplates_of(scene))
    kept = SimpleNamespace(backplates=(whole, cut), frame_px=(16, 12))
    bridge.write_backplate(kept, (16, 12), probe, probe)
    found = in_extension("spectral_probe.composite.backplate_file").load_backplate(probe / "backplate.json")
    assert found.photo == probe / "plate.exr"
    assert found.frame_px == (0.0, 0.0, 16, 12)
    assert found.camera.focal_px == pytest.approx((20.0, 20.0))
    bridge.write_backplate(kept, (8, 6), probe, probe)  # cut to a border
    border = in_extension("spectral_probe.composite.backplate_file").load_backplate(probe / "backplate.json")
    assert (border.camera.size_px, border.photo) == ((8, 6), Path())
    scene.render.resolution_x = 128  # another picture: the plate's camera no longer
    assert in_extension("operators.bridge.backplate").scene_backplate(scene) is None


@pytest.mark.usefixtures("ready")
def test_the_ground_does_not_hide_the_photograph() -> None:
    bpy.ops.spectral_probe.match_backplate()
    assert bpy.data.objects["Ground"].display_type == "WIRE"


def test_the_ground_is_laid_anew(ready: Any, scene: Any) -> None:
    bpy.ops.spectral_probe.match_backplate()
    plate = ready.backplate
    plate.ground_source, plate.reflectance, plate.ground_radius = "GIVEN", (0.5, 0.25, 0.125), 0.75
    assert bpy.ops.spectral_probe.add_ground() == {"FINISHED"}
    (ground,) = [thing for thing in scene.objects if thing.type == "MESH" and thing.is_shadow_catcher]
    assert ground.dimensions.x == pytest.approx(1.5, rel=1e-3)
    colour = ground.active_material.node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value
    np.testing.assert_allclose(colour[:3], (0.5, 0.25, 0.125), rtol=1e-4)
    plate.ground_source = "PLATE"
    assert bpy.ops.spectral_probe.add_ground() == {"FINISHED"}
    assert len([thing for thing in scene.objects if thing.type == "MESH" and thing.is_shadow_catcher]) == 1


def test_buttons_say_why_they_are_grey(settings: Any, probe: Path) -> None:
    assert not bpy.ops.spectral_probe.match_backplate.poll()
    settings.probe_directory = str(probe)
    assert not bpy.ops.spectral_probe.match_backplate.poll()
    assert not bpy.ops.spectral_probe.add_ground.poll()
    settings.backplate.plate = str(probe / "plate.exr")
    assert bpy.ops.spectral_probe.match_backplate.poll()
    settings.backplate.ground_source = "GIVEN"
    assert bpy.ops.spectral_probe.add_ground.poll()


def test_a_plate_of_another_size_is_refused_and_nothing_changes(ready: Any, probe: Path) -> None:
    before = [thing.name for thing in bpy.data.objects]
    ready.backplate.plate = str(probe / "small.exr")
    with pytest.raises(RuntimeError, match="64 x 20 pixels"):
        bpy.ops.spectral_probe.match_backplate()
    assert [thing.name for thing in bpy.data.objects] == before
    assert not ready.backplate.matched


def test_the_verb_writes_a_scene_with_objects_where_the_ball_stood(
    probe: Path, in_extension: Importer, capfd: pytest.CaptureFixture[str]
) -> None:
    run = in_extension("operators.command_line").run
    output = probe / "out" / "scene.blend"
    words = ["backplate", str(probe), "--plate", str(probe / "plate.exr"), "-o", str(output), "--json"]
    assert (
        run([*words, "--object", "gold-pedestal", "--object", "silver-ball", "--object", "copper-ball"]) == 0
    )
    numbers = json.loads(capfd.readouterr().out.splitlines()[-1])
    assert numbers["written"] == str(output)
    assert (output.parent / "scene_alignment.png").is_file()
    bpy.ops.wm.open_mainfile(filepath=str(output))
    scene = bpy.context.scene
    assert in_extension("operators.bridge.backplate").scene_backplate(scene) is not None
    pedestal, silver = bpy.data.objects["Gold Pedestal"], bpy.data.objects["Silver Ball"]
    np.testing.assert_allclose(pedestal.location, 0.0, atol=1e-6)
    copper = bpy.data.objects["Copper Ball"]
    assert copper.dimensions.z == pytest.approx(0.12, rel=1e-3)  # as large as the ball was
    assert copper.location.z == pytest.approx(0.0, abs=1e-6)
    assert silver.location.z == pytest.approx(pedestal.dimensions.z, rel=1e-3)
    assert not any(thing.is_shadow_catcher for thing in (pedestal, silver))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--plate", "small.exr", "-o", "a.blend"], "64 x 20 pixels"),
        (["--plate", "plate.exr", "-o", "a.png"], "is no scene"),
        (["--plate", "plate.exr", "-o", "a.blend", "--iso", "100"], "need the exposure time"),
        (["--plate", "plate.exr", "-o", "a.blend", "--view", "3"], "no view 3"),
    ],
)
def test_bad_input_of_the_verb_is_one_line(
    probe: Path,
    in_extension: Importer,
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    words: list[str],
    message: str,
) -> None:
    monkeypatch.chdir(probe)
    assert in_extension("operators.command_line").run(["backplate", ".", *words]) == 2
    written = capfd.readouterr().err.strip()
    assert message in written
    assert "\n" not in written
    assert not (probe / "a.blend").exists()
