"""The user's own library folder, and names and files where Blender's fields take either."""

import bpy
import pytest

MODULE = "bl_ext.user_default.spectral_probe"


@pytest.fixture
def folder(tmp_path):
    rows = [f"{nm},{nm},{(nm / 500) ** 3},{900 - nm}" for nm in range(380, 790, 10)]
    (tmp_path / "My_Camera.csv").write_text("\n".join(["nm,r,g,b", *rows]))
    wall = [f"{nm},0.25" for nm in range(380, 790, 10)]
    (tmp_path / "wall.csv").write_text("\n".join(["nm,reflectance", *wall]))
    addon = bpy.context.preferences.addons.new()  # as the person's click does; loading it in a test does not
    addon.module = MODULE
    addon.preferences.library_folder = str(tmp_path)
    yield tmp_path
    bpy.context.preferences.addons.remove(addon)


def test_the_folders_cameras_are_offered_and_used(folder, settings, in_extension, tmp_path):
    pickers = in_extension("settings.library_pickers")
    assert ("My Camera", "My_Camera.csv") in pickers.camera_names(None, bpy.context, "camera")
    settings.camera.model = "My Camera"
    view = settings.views.add()
    view.photos.add().path = str(tmp_path / "a.dng")
    capture = in_extension("operators.settings").capture_from(settings)
    assert capture.camera.sensitivities == folder / "My_Camera.csv"
    settings.camera.model = "Nikon 5100 (NPL)"
    assert in_extension("operators.settings").capture_from(settings).camera.sensitivities is None


def test_a_folder_that_is_gone_is_none(folder, in_extension):
    assert in_extension("preferences").library_folder() == folder
    bpy.context.preferences.addons[MODULE].preferences.library_folder = str(folder / "gone")
    assert in_extension("preferences").library_folder() is None


def test_a_reflectance_by_name_or_by_file(folder, in_extension):
    reflectance = in_extension("operators.bridge.spectral_kinds").measured_reflectance
    assert reflectance(str(folder / "wall.csv")) == pytest.approx(0.25)
    assert reflectance("wall") == pytest.approx(0.25)
    assert reflectance("ColorChecker N Ohta: dark skin")[30] == pytest.approx(0.079, abs=1e-3)
    with pytest.raises(in_extension("spectral_probe.errors").SpectralDataError, match="Did you mean"):
        reflectance("dark skinn")


def test_a_measured_ball_is_taken_as_a_file(in_extension):
    settings = in_extension("operators.settings")
    assert settings.material_from(" /balls/my ball.csv ") == "/balls/my ball.csv"
    assert settings.material_from("stainless steel") == "stainless steel"
    assert settings.material_from(settings.material_text("/balls/ball.csv")) == "/balls/ball.csv"
