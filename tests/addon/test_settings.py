"""The settings of a scene hold a capture exactly, and the .blend holds the settings."""

import math
from dataclasses import replace
from pathlib import Path

import bpy
import pytest


@pytest.fixture
def photos(tmp_path: Path) -> tuple[Path, ...]:
    paths = tuple(tmp_path / f"v{number}.dng" for number in range(3))
    for path in paths:
        path.touch()
    return paths


@pytest.fixture
def whole_capture(in_extension, photos):
    model = in_extension("spectral_probe.model")
    return model.Capture(
        views=(
            model.ViewSettings(photos[:2], azimuth_deg=-12.3, elevation_deg=4.5, roll_deg=0.7,
                               refine=False, exposures_s=(0.0005, 0.004), iso=(100.0, 100.0), f_number=(5.6, 5.6),
                               outline=(400.5, 300.25, 210.125)),
            model.ViewSettings(photos[2:], azimuth_deg=120.0),
        ),
        camera=model.CameraSettings("Nikon 5100 (NPL)", focal_px=(5720.3, 5721.9), principal_px=(400.1, 399.9),
                                    distortion=(-0.12, 0.034, 0.0001, -0.0002, 0.5)),
        ball=model.BallSettings(0.0381, {"Fe": 0.74, "Cr": 0.18, "Ni": 0.08}),
        families=("daylight", "led-phosphor"),
        method="paper",
    )  # fmt: skip


def through(settings_module, settings, capture):
    settings_module.fill(settings, capture, Path("/nowhere/capture.toml"))
    return settings_module.capture_from(settings)


def test_a_capture_passes_through_the_settings_unchanged(in_extension, settings, whole_capture):
    assert through(in_extension("operators.settings"), settings, whole_capture) == whole_capture


@pytest.mark.parametrize(
    "camera",
    [
        {},
        {"focal_mm": 35.0, "sensor_width_mm": 23.5},
        {"sensor_width_mm": 23.5},
        {"calibration": Path("/somewhere/camera.json")},
        {"sensitivities": Path("/somewhere/mine.csv"), "focal_px": (900.5, 900.5)},
        {"focal_px": (900.0, 900.0), "distortion": (0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.25)},
    ],
)
def test_every_kind_of_lens_passes_through(in_extension, settings, whole_capture, camera):
    capture = replace(whole_capture, camera=in_extension("spectral_probe.model").CameraSettings(**camera))
    assert through(in_extension("operators.settings"), settings, capture).camera == capture.camera


def test_a_second_capture_leaves_nothing_of_the_first(in_extension, settings, whole_capture):
    module, model = in_extension("operators.settings"), in_extension("spectral_probe.model")
    through(module, settings, whole_capture)
    settings.probe.width_px, settings.comparison.mean_de2000 = 512, 3.0
    plain = model.Capture(views=whole_capture.views[1:], families=("automatic",))
    assert through(module, settings, plain) == plain
    assert (settings.probe.width_px, settings.comparison.mean_de2000) == (0, 0.0)


def test_the_radius_follows_the_scene_unit(in_extension, scene, settings, whole_capture):
    scene.unit_settings.scale_length = 0.01
    capture = through(in_extension("operators.settings"), settings, whole_capture)
    assert settings.ball_radius == pytest.approx(3.81)
    assert capture.ball.radius_m == 0.0381


@pytest.mark.parametrize(
    ("text", "material"),
    [
        ("SUS304", "SUS304"),
        (" chrome ", "chrome"),
        ("Fe 0.74, Cr=0.18,Ni: .08", {"Fe": 0.74, "Cr": 0.18, "Ni": 0.08}),
        ("Ag 1", {"Ag": 1.0}),
    ],
)
def test_ball_materials_are_names_or_fractions(in_extension, text, material):
    assert in_extension("operators.settings").material_from(text) == material


@pytest.mark.usefixtures("scene")
def test_relative_paths_start_at_the_blend(in_extension, tmp_path):
    module = in_extension("operators.settings")
    with pytest.raises(Exception, match=r"Save the \.blend first"):
        module.folder_of("//probe", "probe")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    assert module.folder_of("//probe", "probe") == tmp_path / "probe"


def test_the_blend_keeps_settings_and_results(in_extension, settings, whole_capture, tmp_path):
    module = in_extension("operators.settings")
    capture = through(module, settings, whole_capture)
    settings.views[0].has_outline, settings.views[0].found_rms_px = True, 0.125
    settings.probe.width_px, settings.probe.blind_fraction = 1024, 0.0625
    settings.probe_width, settings.samples, settings.plan = 512, 77, "REFERENCE"
    bpy.data.materials["Material"].spectral_probe.kind = "METAL"
    bpy.data.materials["Material"].spectral_probe.metal = "Cu"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert not bpy.context.scene.spectral_probe.views
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))

    kept = bpy.context.scene.spectral_probe
    assert module.capture_from(kept) == capture
    assert (kept.views[0].has_outline, kept.views[0].found_rms_px) == (True, 0.125)
    assert (kept.probe.width_px, kept.probe.blind_fraction) == (1024, 0.0625)
    assert (kept.probe_width, kept.samples, kept.plan) == (512, 77, "REFERENCE")
    assert bpy.data.materials["Material"].spectral_probe.metal == "Cu"


def test_angles_are_radians_inside(in_extension, settings, whole_capture):
    through(in_extension("operators.settings"), settings, whole_capture)
    assert settings.views[1].azimuth == pytest.approx(math.radians(120))


@pytest.mark.parametrize("relative", [True, False])
def test_paths_follow_blenders_preference(scene, tmp_path, relative, monkeypatch):
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "v0.exr").touch()
    (tmp_path / "blends").mkdir()
    monkeypatch.setattr(bpy.context.preferences.filepaths, "use_relative_paths", relative)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "blends" / "scene.blend"))
    bpy.ops.spectral_probe.add_view(directory=str(tmp_path / "photos"), files=[{"name": "v0.exr"}])
    kept = scene.spectral_probe.views[0].photos[0].path
    assert kept == ("//../photos/v0.exr" if relative else str(tmp_path / "photos" / "v0.exr"))
