"""Presets keep settings as data: saved, loaded, refused where they are none."""

from pathlib import Path

import bpy
import pytest

ops = bpy.ops.spectral_probe
KINDS = ("capture", "lamps", "render")


@pytest.fixture
def own_presets():
    """Where the user's presets lie; emptied afterwards."""
    folder = Path(bpy.utils.user_resource("SCRIPTS", path="presets/spectral_probe", create=True))
    yield folder
    for file in folder.rglob("*.toml"):
        file.unlink()


def built_in(project_root, kind):
    return sorted((project_root / "presets" / "spectral_probe" / kind).glob("*.toml"))


def shown(drawn, kind):
    """The names that the menu of a kind lists."""
    widgets = drawn(getattr(bpy.types, f"SPECTRAL_PROBE_PT_{kind}_presets"))
    return [w["draw_string"] for w in widgets if ".load_preset(" in w.get("operator", "")]


@pytest.mark.parametrize("kind", KINDS)
def test_every_built_in_preset_loads_and_changes_what_it_says(settings, project_root, in_extension, kind):
    read_preset = in_extension("spectral_probe.files.preset_file").read_preset
    files = built_in(project_root, kind)
    assert len(files) > 1
    for file in files:
        assert ops.load_preset(filepath=str(file), kind=kind) == {"FINISHED"}
        for name, value in read_preset(file).items():
            now = settings.path_resolve(name)
            expected = set(value) if isinstance(now, set) else value
            assert now == (pytest.approx(expected) if isinstance(value, float) else expected), (
                f"{file.name}: {name}"
            )


def test_built_in_names_exist_in_the_library(project_root, in_extension):
    read_preset = in_extension("spectral_probe.files.preset_file").read_preset
    cameras = ("", *in_extension("spectral_probe.spectra.camera_names").LIBRARY_CAMERAS)
    balls = in_extension("spectral_probe.spectra.metals").BALL_MATERIALS
    for file in built_in(project_root, "capture"):
        preset = read_preset(file)
        assert preset["camera.model"] in cameras
        assert preset["ball_material"] in balls


def test_save_and_load_gives_the_same_settings(settings, own_presets, drawn):
    settings.camera.model, settings.camera.focal_source, settings.camera.focal_px = (
        "My Camera",
        "PX",
        (4000.5, 4001),
    )
    settings.id_data.unit_settings.scale_length = 0.01
    settings.ball_radius, settings.ball_material = 5.0, 'Fe 0.8, Cr 0.2 "polished"'
    assert ops.save_preset(name="Studio ball", kind="capture") == {"FINISHED"}
    assert "Studio ball" in shown(drawn, "capture")
    text = (own_presets / "capture" / "Studio_ball.toml").read_text(encoding="utf-8")
    assert "ball_radius = 0.05" in text, "in metres, whatever the scene's unit"
    for name in ("camera", "ball_radius", "ball_material"):
        settings.property_unset(name)
    assert not settings.camera.model
    assert ops.load_preset(filepath=str(own_presets / "capture" / "Studio_ball.toml"), kind="capture") == {
        "FINISHED"
    }
    assert (settings.camera.model, settings.camera.focal_source) == ("My Camera", "PX")
    assert tuple(settings.camera.focal_px) == (4000.5, 4001.0)
    assert settings.ball_radius == pytest.approx(5.0)
    assert settings.ball_material == 'Fe 0.8, Cr 0.2 "polished"'


def test_lamps_are_kept_as_a_set(settings, own_presets):
    settings.families = {"led-rgb", "daylight"}
    ops.save_preset(name="LED", kind="lamps")
    settings.families = {"incandescent"}
    ops.load_preset(filepath=str(own_presets / "lamps" / "LED.toml"), kind="lamps")
    assert settings.families == {"led-rgb", "daylight"}


@pytest.mark.usefixtures("scene")
def test_names_that_are_taken_and_presets_that_stay(own_presets, drawn):
    ops.save_preset(name="Mine", kind="render")
    with pytest.raises(RuntimeError, match="called Mine already"):
        ops.save_preset(name="Mine", kind="render")
    with pytest.raises(RuntimeError, match="Give the preset a name"):
        ops.save_preset(name="  ", kind="render")
    with pytest.raises(RuntimeError, match="came with Spectral Probe"):
        ops.save_preset(name="1 Draft", remove_name=True, kind="render")
    assert shown(drawn, "render") == ["1 Draft", "2 Normal", "3 Final", "Mine"]
    ops.save_preset(name="Mine", remove_name=True, kind="render")
    assert not list(own_presets.rglob("*.toml"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("import os", "is no preset"),
        ("samples = 7\nprobe_directory = '/etc'", "sets probe_directory"),
        ("samples = 7\n[rgb_twin]\nx = 1", "sets rgb_twin.x"),
        ("samples = 7\nplan = 'OTHER'", "plan cannot be 'OTHER'"),
        ("samples = 7\nmax_de2000 = 'low'", "max_de2000 cannot be 'low'"),
        ("samples = 7\nrgb_twin = 2026-01-01", "rgb_twin is no plain value"),
        ("samples = [1, 2]", "samples cannot be"),
    ],
)
def test_what_is_no_preset_changes_nothing(settings, tmp_path, text, message):
    path = tmp_path / "bad.toml"
    path.write_text(text, encoding="utf-8")
    before = (settings.samples, settings.probe_directory, settings.plan)
    with pytest.raises(RuntimeError, match=message):
        ops.load_preset(filepath=str(path), kind="render")
    assert (settings.samples, settings.probe_directory, settings.plan) == before


@pytest.mark.usefixtures("scene")
def test_a_preset_that_is_not_there(tmp_path):
    with pytest.raises(RuntimeError, match="cannot be read"):
        ops.load_preset(filepath=str(tmp_path / "none.toml"), kind="render")


def test_the_folder_is_given_back(extension, project_root):
    def searched():
        return any(
            Path(path).resolve().is_relative_to(project_root)
            for path in bpy.utils.preset_paths("spectral_probe/lamps")
        )

    assert searched()
    extension.unregister()
    try:
        assert not searched()
    finally:
        extension.register()
