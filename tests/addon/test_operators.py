"""Operators give what the functions behind them give, report what the user can put right, and say why they are grey."""

import json
from pathlib import Path

import bpy
import numpy as np
import pytest

ops = bpy.ops.spectral_probe


def finish(job):
    while True:
        try:
            next(job)
        except StopIteration as stop:
            return stop.value


@pytest.fixture
def imported(settings, capture_file):
    assert ops.import_capture(filepath=str(capture_file)) == {"FINISHED"}
    settings.probe_width = 64
    return settings


@pytest.fixture(scope="module")
def probe_folder(tmp_path_factory, in_extension) -> Path:
    """A probe of even daylight from everywhere."""
    model, grid = in_extension("spectral_probe.model"), in_extension("spectral_probe.spectra.grid")
    probe = in_extension("spectral_probe.probe")
    weights = np.zeros((32, 64, 3), np.float32)
    weights[..., 0] = 1
    panorama = model.SpectralPanorama(
        weights=weights,
        bases=np.ones((1, 3, len(grid.WAVELENGTHS_NM))) * np.array([1.0, 0.5, 0.25])[:, None],
        basis_index=np.zeros((32, 64), np.uint8),
        wavelengths_nm=grid.WAVELENGTHS_NM,
        valid=np.ones((32, 64), bool),
        confidence=np.ones((32, 64), np.float32),
    )
    folder = tmp_path_factory.mktemp("probe")
    finish(probe.write_outputs(probe.Probe(panorama, {"seconds": {}}), folder))
    return folder


@pytest.fixture
def render_folder(tmp_path, in_extension) -> Path:
    """A spectral render and its RGB twin, slightly too red and with a broken pixel; a ball covers the middle."""
    model = in_extension("spectral_probe.composite_model")
    ball = np.zeros((24, 32), np.float32)
    ball[8:16, 10:20], ball[7, 10:20] = 1, 0.4
    covered = model.ObjectCoverage({"Ball": ball}, ball, np.zeros_like(ball))
    in_extension("spectral_probe.files.objects_exr").write_objects(tmp_path / "objects.exr", covered)
    write_rgb = in_extension("spectral_probe.files.image_exr").write_rgb
    to_xyz = in_extension("spectral_probe.spectra.colorimetry").rec709_to_xyz
    rgb = np.full((24, 32, 3), 0.4, np.float32) + np.linspace(0, 0.2, 32, dtype=np.float32)[:, None]
    write_rgb(tmp_path / "xyz.exr", to_xyz(rgb), ("X", "Y", "Z"))
    red = rgb * np.array([1.1, 1.0, 1.0], np.float32)
    red[3, 4] = np.nan
    write_rgb(tmp_path / "rgb.exr", red)
    return tmp_path


# ---------------------------------------------------------------- capture


def test_import_fills_the_settings(imported, capture_file, in_extension):
    capture = in_extension("spectral_probe.files.capture").load_capture(capture_file)
    assert in_extension("operators.settings").capture_from(imported) == capture
    assert imported.capture_path == str(capture_file)
    assert [view.name for view in imported.views] == ["view_0", "view_1"]


@pytest.mark.parametrize("verb", ["build_probe", "light_from_photographs"])
def test_a_folder_that_cannot_be_written_to_is_refused_at_once(imported, tmp_path, verb):
    (tmp_path / "file").write_text("not a folder")
    imported.probe_directory = str(tmp_path / "file" / "probe")
    with pytest.raises(RuntimeError, match="is a file, not a folder"):
        getattr(ops, verb)()
    imported.probe_directory = "//probe"
    with pytest.raises(RuntimeError, match=r"Save the \.blend first"):
        getattr(ops, verb)()


def test_a_render_into_a_file_is_refused_at_once(imported, scene, tmp_path):
    (tmp_path / "file").write_text("not a folder")
    scene.render.engine = "CYCLES"
    imported.light, imported.render_directory = "WORLD", str(tmp_path / "file" / "render")
    for verb in (ops.render_spectral, ops.render_and_compare):
        with pytest.raises(RuntimeError, match="is a file, not a folder"):
            verb()


def test_import_into_an_unsaved_blend_puts_folders_beside_the_capture(imported, capture_file):
    assert Path(imported.probe_directory) == capture_file.parent / "probe"


@pytest.mark.usefixtures("scene")
def test_import_into_a_saved_blend_keeps_its_folders(capture_file, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    ops.import_capture(filepath=str(capture_file))
    assert bpy.context.scene.spectral_probe.probe_directory == "//spectral_probe/probe/"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, r"There is no capture file at .*nothing\.toml\. Check the path\."),
        ("[camera", r"is not valid TOML: .* Correct that line\."),
        ("[camra]", r'there is no key "camra"\. Did you mean "camera"\?'),
        ("", "has no view. Add a"),
    ],
)
def test_import_reports_what_is_wrong_and_changes_nothing(imported, tmp_path, text, message):
    path = tmp_path / "nothing.toml"
    if text is not None:
        path.write_text(text)
    with pytest.raises(RuntimeError, match=message):
        ops.import_capture(filepath=str(path))
    assert len(imported.views) == 2


def test_a_saved_capture_is_the_imported_one(imported, capture_file, in_extension):
    saved = capture_file.with_name("again.toml")
    assert ops.save_capture(filepath=str(saved.with_suffix(""))) == {"FINISHED"}
    load_capture = in_extension("spectral_probe.files.capture").load_capture
    assert load_capture(saved) == load_capture(capture_file)
    assert imported.capture_path == str(saved)


def test_views_are_added_and_removed(settings, capture_file):
    folder = str(capture_file.parent)
    assert ops.add_view(directory=folder, files=[{"name": "view_0.exr"}, {"name": "view_1.exr"}]) == {
        "FINISHED"
    }
    assert [Path(photo.path).name for photo in settings.views[0].photos] == ["view_0.exr", "view_1.exr"]
    ops.add_view(directory=folder, files=[{"name": "view_1.exr"}])
    assert (len(settings.views), settings.active_view) == (2, 1)
    ops.remove_view()
    assert (len(settings.views), settings.active_view, settings.views[0].name) == (1, 0, "view_0")
    with pytest.raises(RuntimeError, match=r"There is no photograph .*lost\.dng"):
        ops.add_view(directory=folder, files=[{"name": "lost.dng"}])


# ---------------------------------------------------------------- ball and probe


def test_detect_ball_shows_the_outline(imported):
    assert ops.detect_ball() == {"FINISHED"}
    view = imported.views[0]
    assert view.has_outline
    assert tuple(view.found_centre_px) == pytest.approx((80, 60))
    assert tuple(view.found_semi_axes_px) == pytest.approx((50, 50))
    picture = view.shown.picture
    assert (picture.name, tuple(picture.size), tuple(view.shown.size_px)) == (
        "view_0 (1)",
        (160, 120),
        (160, 120),
    )
    assert picture.packed_file is not None


def test_detect_ball_finds_it_and_gives_a_start_for_corrections(imported, in_extension):
    imported.views[1].outline_source = "AUTOMATIC"
    imported.views[1].outline_px = (0, 0, 0)
    imported.active_view, imported.all_views = 1, False
    assert ops.detect_ball() == {"FINISHED"}
    assert not imported.views[0].has_outline
    photograph = in_extension("spectral_probe.photo.read").read_photograph(
        Path(imported.views[1].photos[0].path)
    )
    detected = in_extension("spectral_probe.geometry.outline").find_ball([photograph]).outlines[0]
    assert tuple(imported.views[1].found_centre_px) == pytest.approx(detected.centre_px)
    assert tuple(imported.views[1].outline_px)[:2] == pytest.approx(detected.centre_px)
    assert imported.views[1].found_rms_px == pytest.approx(detected.rms_px, rel=1e-5)


def test_detect_ball_reports_a_ball_cut_by_the_frame(imported):
    imported.views[0].outline_px = (20, 60, 50)
    with pytest.raises(RuntimeError, match="ball"):
        ops.detect_ball()
    assert not any(view.has_outline for view in imported.views)


def test_build_probe_gives_what_the_function_gives(imported, capture_file, in_extension):
    assert ops.build_probe() == {"FINISHED"}
    load_capture = in_extension("spectral_probe.files.capture").load_capture
    read_probe = in_extension("spectral_probe.files.probe_exr").read_probe
    expected = finish(in_extension("spectral_probe.probe").build_probe(load_capture(capture_file), 64))
    written = read_probe(Path(imported.probe_directory) / "probe.exr")
    np.testing.assert_array_equal(written.weights, expected.panorama.weights)
    np.testing.assert_array_equal(written.valid, expected.panorama.valid)
    assert (imported.probe.width_px, imported.probe.height_px) == (64, 32)
    assert imported.probe.blind_fraction == pytest.approx(expected.report["blind_fraction"])
    assert imported.views[1].probe_rms_px == pytest.approx(expected.report["views"][1]["outline_rms_px"])
    assert imported.views[1].has_probe


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda settings: setattr(settings.views[1].photos[0], "path", ""), "lacks a photograph"),
        (lambda settings: setattr(settings.views[1].photos[0], "path", "/lost.dng"), "lost.dng"),
        (lambda settings: setattr(settings.camera, "model", "Nikon 5101 (NPL)"), 'Did you mean "Nikon 5100'),
        (lambda settings: setattr(settings, "families", set()), "No lamp family is chosen"),
        (lambda settings: setattr(settings, "ball_material", "Fe 0.7, Xx 0.3"), "Xx"),
        (lambda settings: setattr(settings.camera, "focal_px", (0, 0)), "focal length in pixels is 0"),
        (lambda settings: setattr(settings.views[0], "outline_px", (80, 60, 0)), "has no radius"),
        (lambda settings: setattr(settings, "probe_width", 65), "even"),
        (lambda settings: setattr(settings, "probe_directory", "//x"), r"Save the \.blend first"),
        (
            lambda settings: setattr(settings, "probe_directory", settings.capture_path),
            "is a file, not a folder",
        ),
    ],
)
def test_build_probe_reports_and_writes_nothing(imported, capture_file, spoil, message):
    spoil(imported)
    with pytest.raises(RuntimeError, match=message) as report:
        ops.build_probe()
    assert len(str(report.value).strip().splitlines()) == 1
    assert not list((capture_file.parent / "probe").glob("*.exr"))
    assert not imported.probe.width_px


def test_build_probe_asks_for_the_exposure_of_a_photograph_without_exif(imported, capture_file):
    from PIL import Image

    path = capture_file.with_name("view.png")
    Image.fromarray(np.full((120, 160, 3), 90, np.uint8)).save(path)
    imported.views[0].photos[0].path, imported.views[0].photos[0].exposure_s = str(path), 0
    with pytest.raises(RuntimeError, match="exposure"):
        ops.build_probe()


# ---------------------------------------------------------------- world, objects, render, comparison


def test_light_world_lights_the_scene_with_the_panorama(scene, settings, probe_folder):
    settings.probe_directory = str(probe_folder)
    before = scene.world
    assert ops.light_world() == {"FINISHED"}
    assert scene.world != before
    images = [node.image for node in scene.world.node_tree.nodes if node.type == "TEX_ENVIRONMENT"]
    assert Path(images[0].filepath) == probe_folder / "world.exr"


@pytest.mark.parametrize(("normalise", "strength"), [(True, 1.0), (True, 0.5), (False, 2.0)])
def test_light_world_scales_and_turns_the_light(
    scene, settings, probe_folder, in_extension, normalise, strength
):
    settings.probe_directory = str(probe_folder)
    ops.light_world(normalise=normalise, strength=strength, rotation=0.5)
    (_, _, rotation_rad), factor = in_extension("operators.bridge.world").placement(scene.world)
    assert rotation_rad == pytest.approx(0.5)
    luminance = spectra_luminance(probe_folder, in_extension)
    assert factor * (luminance if normalise else 1.0) == pytest.approx(strength, rel=1e-4)


def spectra_luminance(probe_folder, in_extension) -> float:
    """Y of the even light of the probe."""
    panorama = in_extension("spectral_probe.files.probe_exr").read_probe(probe_folder / "probe.exr")
    spectrum = panorama.weights[0, 0] @ panorama.bases[0]
    return float(in_extension("spectral_probe.spectra.colorimetry").spectra_to_xyz(spectrum)[1])


@pytest.mark.parametrize(
    ("kind", "metal"), [("GOLD_PEDESTAL", "Au"), ("SILVER_BALL", "Ag"), ("COPPER_BALL", "Cu")]
)
def test_objects_are_of_measured_metal_and_stand_at_the_cursor(scene, kind, metal):
    scene.cursor.location = (1, 2, 0)
    before = set(scene.objects)
    assert ops.add_object(kind=kind) == {"FINISHED"}
    added = set(scene.objects) - before
    assert bpy.context.active_object in added
    assert bpy.context.selected_objects == [bpy.context.active_object]
    settings = bpy.context.active_object.active_material.spectral_probe
    assert (settings.kind, settings.metal) == ("METAL", metal)
    assert tuple(bpy.context.active_object.location)[:2] == pytest.approx((1, 2))


def test_render_gives_what_the_function_gives(scene, settings, probe_folder, tmp_path, in_extension):
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 16, 12, 100
    bpy.data.materials["Material"].spectral_probe.kind = "METAL"
    settings.probe_directory, settings.render_directory = str(probe_folder), str(tmp_path / "operator")
    settings.plan, settings.passes, settings.samples = "NUMBER", 2, 1
    assert ops.render_spectral() == {"FINISHED"}
    read_rgb = in_extension("spectral_probe.files.image_exr").read_rgb
    probe = in_extension("spectral_probe.files.probe_exr").read_probe(probe_folder / "probe.exr")
    expected = finish(
        in_extension("operators.bridge.cycles").spectral_render(
            scene, probe, None, tmp_path / "function", samples=1, passes=2, rgb_twin=False
        )
    )
    np.testing.assert_array_equal(
        read_rgb(tmp_path / "operator" / "xyz.exr", ("X", "Y", "Z")), read_rgb(expected.xyz, ("X", "Y", "Z"))
    )
    assert (settings.render.passes, settings.render.samples, settings.render.has_rgb) == (2, 1, True)
    assert settings.render.seconds > 0
    assert (tmp_path / "operator" / "rgb.exr").is_file()
    shown = bpy.data.images["Spectral Render"]
    assert tuple(shown.size) == (16, 12)
    assert np.mean(shown.pixels[:]) > 0.05  # in the unit of the photographs


def test_compare_gives_what_the_command_gives(settings, render_folder, tmp_path, in_extension, monkeypatch):
    settings.render_directory = str(render_folder)
    assert ops.compare() == {"FINISHED"}
    module = in_extension("spectral_probe.compare_command")
    job = module.compare(render_folder / "xyz.exr", render_folder / "rgb.exr", tmp_path / "function")
    with monkeypatch.context() as patch:
        patch.setattr(module, "draw_comparison", lambda *_: iter(()))  # the numbers will do
        finish(job)
    numbers = json.loads((tmp_path / "function" / "compare.json").read_text())
    assert settings.comparison.mean_de2000 == pytest.approx(numbers["image"]["raw"]["mean"])
    assert settings.comparison.mean_de2000 > 1
    assert tuple(settings.comparison.xy_shift) == pytest.approx(numbers["image"]["xy_shift"])
    assert [ball.name for ball in settings.compare.objects] == ["Ball"]
    assert settings.compare.objects[0].mean_de2000 == pytest.approx(numbers["objects"][0]["raw"]["mean"])
    assert "1 pixel of rgb.exr is not a number" in settings.comparison.warnings
    sheet = bpy.data.images["Spectral Probe Comparison"]
    assert Path(sheet.filepath) == render_folder / "comparison" / "sheet.png"
    assert sheet.size[0] > 1000
    _wipe_follows_its_slider(settings, render_folder / "comparison")


def _wipe_follows_its_slider(settings, folder):
    """The wipe is shown in the image editor, and moving the slider moves its divider there."""
    assert ops.show_comparison(view="WIPE") == {"FINISHED"}
    wipe = bpy.data.images["Spectral Probe Wipe"]
    spectral, rgb = (bpy.data.images.load(str(folder / f"{name}.png")) for name in ("spectral", "rgb"))
    width, height = wipe.size

    def pixels(image):
        values = np.empty(width * height * 4, np.float32)
        image.pixels.foreach_get(values)
        return values.reshape(height, width, 4)

    for split, column in ((0.5, width // 2), (0.25, width // 4)):
        settings.compare.split = split
        shown = pixels(wipe)
        np.testing.assert_array_equal(shown[:, : column - 1], pixels(spectral)[:, : column - 1])
        np.testing.assert_array_equal(shown[:, column + 2 :], pixels(rgb)[:, column + 2 :])
        assert (shown[:, column, :3] == 1).all()
    for view, name in (
        ("MAP", "Colour Difference"),
        ("WAYS", "Four Ways of RGB"),
        ("CHROMATICITY", "Chromaticity"),
    ):
        assert ops.show_comparison(view=view) == {"FINISHED"}
        assert bpy.data.images[f"Spectral Probe {name}"].size[0] > 500
    (folder / "rgb.png").unlink()
    settings.compare.split = 0.75  # nothing to draw it of: what is shown stays
    with pytest.raises(RuntimeError, match="Compare the renders again"):
        ops.show_comparison(view="WIPE")


@pytest.mark.parametrize(
    ("chosen", "expected"),
    [
        ({"light": "RENDER"}, ("", None)),
        ({"light": "LAMP", "lamp": "FL11"}, ("FL11", None)),
        ({"light": "LAMP", "lamp_path": "/lamps/mine.csv"}, ("/lamps/mine.csv", None)),
        ({"light": "PROBE"}, ("/probe/probe.exr", None)),
        (
            {"light": "DIRECTION", "azimuth": -np.pi / 2, "elevation": 0.5},
            ("/probe/probe.exr", (270.0, 28.6479)),
        ),
    ],
)
def test_the_light_of_the_four_ways_is_the_panels(settings, in_extension, chosen, expected):
    settings.probe_directory = "/probe"
    settings.compare.metals = "Au, , main/Cu/McPeak"
    for name, value in chosen.items():
        setattr(settings.compare, name, value)
    read = in_extension("operators.compare").compare_settings_from(settings)
    assert read.light == expected[0]
    assert read.at == (expected[1] and pytest.approx(expected[1], abs=1e-3))
    assert read.metals == ("Au", "main/Cu/McPeak")


def test_a_probes_light_needs_a_probe(settings, render_folder):
    settings.render_directory = str(render_folder)
    settings.compare.light = "PROBE"
    with pytest.raises(RuntimeError, match="Build the probe first, or choose another light"):
        ops.compare()


# ---------------------------------------------------------------- grey buttons


@pytest.mark.parametrize(
    ("verb", "reason"),
    [
        ("save_capture", "Import a capture or add a view first"),
        ("remove_view", "Import a capture or add a view first"),
        ("detect_ball", "Import a capture or add a view first"),
        ("build_probe", "Import a capture or add a view first"),
        ("light_world", "Build the probe first"),
        ("render_spectral", "Build the probe first"),
        ("compare", "Render the scene spectrally first"),
        ("show_comparison", "Compare the renders first"),
    ],
)
@pytest.mark.usefixtures("scene")
def test_a_grey_button_says_why(verb, reason):
    operator = getattr(ops, verb)
    assert not operator.poll()
    with pytest.raises(RuntimeError, match=reason):
        operator()


def test_rendering_needs_cycles(settings, probe_folder):
    settings.probe_directory = str(probe_folder)
    with pytest.raises(RuntimeError, match="Set the render engine to Cycles"):
        ops.render_spectral()


def test_comparing_needs_the_rgb_twin(settings, render_folder):
    settings.render_directory = str(render_folder)
    assert ops.compare.poll()
    (render_folder / "rgb.exr").unlink()
    with pytest.raises(RuntimeError, match="Render again with Also RGB on"):
        ops.compare()


def test_objects_are_added_in_object_mode(scene):
    bpy.ops.object.mode_set(mode="EDIT")
    try:
        with pytest.raises(RuntimeError, match="Switch to object mode first"):
            ops.add_object(kind="SILVER_BALL")
    finally:
        bpy.ops.object.mode_set(mode="OBJECT")
    assert scene.objects


# ---------------------------------------------------------------- undo


@pytest.mark.usefixtures("scene")
def test_undo_takes_back_an_import(capture_file):
    bpy.ops.ed.undo_push(message="before")
    ops.import_capture("EXEC_DEFAULT", True, filepath=str(capture_file))  # True: undo as from the window
    assert len(bpy.context.scene.spectral_probe.views) == 2
    bpy.ops.ed.undo()
    assert len(bpy.context.scene.spectral_probe.views) == 0
    bpy.ops.ed.redo()
    assert len(bpy.context.scene.spectral_probe.views) == 2


@pytest.mark.usefixtures("scene")
def test_undo_takes_back_an_object():
    bpy.ops.ed.undo_push(message="before")
    before = len(bpy.context.scene.objects)
    ops.add_object("EXEC_DEFAULT", True, kind="SILVER_BALL")
    assert len(bpy.context.scene.objects) > before
    bpy.ops.ed.undo()
    assert len(bpy.context.scene.objects) == before
