"""The button that writes a farm job: what the panels say is in it, and what cannot be shared is refused."""

import bpy
import numpy as np
import pytest
import yaml


@pytest.fixture
def saved(scene, settings, in_extension, tmp_path):
    """A saved scene with a camera, lit by a probe of even light."""
    wavelengths_nm = in_extension("spectral_probe.spectra.grid").WAVELENGTHS_NM
    panorama = in_extension("spectral_probe.model").SpectralPanorama(
        weights=np.ones((16, 32, 3), np.float32),
        bases=np.ones((1, 3, len(wavelengths_nm))),
        basis_index=np.zeros((16, 32), np.uint8),
        wavelengths_nm=wavelengths_nm,
        valid=np.ones((16, 32), bool),
        confidence=np.ones((16, 32), np.float32),
    )
    (tmp_path / "probe").mkdir()
    in_extension("spectral_probe.files.probe_exr").write_probe(tmp_path / "probe" / "probe.exr", panorama)
    scene.render.engine = "CYCLES"
    scene.frame_start, scene.frame_end, scene.frame_step = 2, 8, 3
    settings.probe_directory, settings.render_directory = str(tmp_path / "probe"), str(tmp_path / "frames")
    settings.samples, settings.output.adapt, settings.output.white = 12, True, "D50"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shot.blend"))
    return bpy.context.scene.spectral_probe


def test_it_holds_the_settings_of_the_panels(saved, tmp_path):
    bpy.ops.spectral_probe.export_farm_job(directory=str(tmp_path / "job"))
    values = yaml.safe_load((tmp_path / "job" / "openjd_values.yaml").read_text())
    assert values == {
        "Scene": str(tmp_path / "shot.blend"),
        "Probe": str(tmp_path / "probe" / "probe.exr"),
        "Output": str(tmp_path / "frames"),
        "Frames": "2-8:3",
        "Samples": 12,
        "ErrorBound": saved.max_de2000,
        "Blender": "blender",
    }
    template = yaml.safe_load((tmp_path / "job" / "template.yaml").read_text())
    words = template["steps"][0]["script"]["actions"]["onRun"]["args"]
    assert words[words.index("--white") + 1] == "D50"
    assert [step["name"] for step in template["steps"]] == ["Render", "Combine", "Compare"]
    assert bpy.context.scene.frame_current == 1


def test_a_list_of_commands(saved, tmp_path):
    saved.rgb_twin = False
    bpy.ops.spectral_probe.export_farm_job(
        directory=str(tmp_path / "job"), format="COMMANDS", blender="/opt/b 5/blender"
    )
    lines = (tmp_path / "job" / "commands.txt").read_text().splitlines()
    assert all(line.startswith(("#", "'/opt/b 5/blender' --background")) for line in lines)
    assert all("--no-rgb" in line for line in lines if " render-pass " in line)


@pytest.mark.usefixtures("saved")
def test_a_folder_with_something_else_is_refused(tmp_path):
    with pytest.raises(RuntimeError, match="holds something else"):
        bpy.ops.spectral_probe.export_farm_job(directory=str(tmp_path / "probe"))


def test_regions_in_no_file_are_refused(saved, tmp_path):
    saved.swap.items.add().name = "window"
    with pytest.raises(RuntimeError, match="Swappable regions"):
        bpy.ops.spectral_probe.export_farm_job(directory=str(tmp_path / "job"))
    assert not (tmp_path / "job").exists()


def test_a_scene_that_was_never_saved_has_no_button(scene):
    scene.render.engine = "CYCLES"
    assert not bpy.ops.spectral_probe.export_farm_job.poll()
