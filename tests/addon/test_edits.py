"""Glasses and lamps in Blender: what the operators make is what the functions make, and everything can be taken back."""

import math
from pathlib import Path

import bpy
import numpy as np
import pytest

ops = bpy.ops.spectral_probe
HEIGHT, WIDTH = 32, 64


@pytest.fixture
def core(in_extension):
    """Modules of the extension's own core."""
    return lambda name: in_extension(f"spectral_probe.{name}")


@pytest.fixture
def probe_folder(tmp_path, core):
    """A probe of two daylight windows, at bearings 0 and 90, in a dim room."""
    frames, editing = core("geometry.frames"), core("editing")
    directions = frames.panorama_directions(HEIGHT, WIDTH)
    level = np.full((HEIGHT, WIDTH), 0.05, np.float32)
    for azimuth in (0, 90):
        level[directions @ frames.bearing_to_direction(azimuth, 10) > math.cos(math.radians(15))] = 1
    whole = np.ones((HEIGHT, WIDTH), bool)
    panorama = core("model").SpectralPanorama(
        level[..., None],
        core("spectra.library").daylight(6500.0)[None, None],
        np.zeros((HEIGHT, WIDTH), np.uint8),
        core("spectra.grid").WAVELENGTHS_NM,
        whole,
        whole.astype(np.float32),
    )
    core("model").finish(editing._write_light(panorama, tmp_path / "probe"))
    return tmp_path / "probe"


@pytest.fixture
def settings(scene, probe_folder):
    settings = scene.spectral_probe
    settings.probe_directory = str(probe_folder)
    settings.region.azimuth, settings.region.elevation = 0, math.radians(10)
    return settings


def panorama_of(settings, core):
    """The probe that renders use now."""
    folder = Path(settings.probe_directory)
    folder = folder / "edits" / settings.edits.state if settings.edits.state else folder
    return core("files.probe_exr").read_probe(folder / "probe.exr")


def names(settings):
    return [item.name for item in settings.edits.items]


def world_image(scene):
    return next(node.image for node in scene.world.node_tree.nodes if node.type == "TEX_ENVIRONMENT")


def test_add_glass_gives_what_the_function_gives(settings, probe_folder, core):
    original = (probe_folder / "probe.exr").read_bytes()
    assert ops.add_glass() == {"FINISHED"}
    edits, regions, model = core("spectra.edits"), core("spectra.regions"), core("model")
    before = core("files.probe_exr").read_probe(probe_folder / "probe.exr")
    region = model.Region(seed_deg=(0.0, 10.0))
    expected = edits.apply_edit(
        before, edits.glass_edit(before, "red", regions.describe(region)), regions.region_mask(region, before)
    )
    edited = panorama_of(settings, core)
    assert edited.bases.tobytes() == expected.bases.tobytes()
    assert edited.basis_index.tobytes() == expected.basis_index.tobytes()
    assert names(settings) == ["red"]
    assert settings.edits.items[0].region == "grown from 0,10"
    cap = 2 * math.pi * (1 - math.cos(math.radians(15)))
    assert settings.edits.items[0].solid_angle_sr == pytest.approx(cap, rel=0.1)
    assert (probe_folder / "probe.exr").read_bytes() == original


def test_replace_lamp(settings, core):
    settings.region.lamp, settings.region.keeps = "FL11", "power"
    assert ops.replace_lamp() == {"FINISHED"}
    (edit,) = panorama_of(settings, core).edits
    assert (edit.kind, edit.name, edit.keeps) == ("lamp", "FL11", "power")
    assert settings.edits.items[0].kind == "lamp"


def test_a_glass_from_a_file(settings, tmp_path, core):
    (tmp_path / "grey.csv").write_text("wavelength_nm,transmittance\n400,0.5\n700,0.5\n")
    settings.region.glass_path = str(tmp_path / "grey.csv")
    ops.add_glass()
    assert panorama_of(settings, core).edits[0].name == "grey.csv"


def test_a_polygon(settings, core):
    settings.region.kind = "POLYGON"
    settings.region.polygon = "-20,-10; 20,-10; 20,30; -20,30;"
    ops.add_glass()
    corners = ((-20, -10), (20, -10), (20, 30), (-20, 30))
    expected = core("spectra.regions").polygon_mask(corners, HEIGHT, WIDTH)
    assert np.array_equal(panorama_of(settings, core).basis_index == 1, expected)


def test_a_painted_mask_is_upright(settings, core):
    image = bpy.data.images.new("painted", WIDTH, HEIGHT, alpha=True)
    pixels = np.zeros((HEIGHT, WIDTH, 4), np.float32)
    pixels[..., 3] = 1
    pixels[-10:, :20, :3] = 1  # Blender's last row is the highest
    image.pixels.foreach_set(pixels.ravel())
    settings.region.kind, settings.region.mask = "MASK", image
    ops.add_glass()
    expected = np.zeros((HEIGHT, WIDTH), bool)
    expected[:10, :20] = True
    assert np.array_equal(panorama_of(settings, core).basis_index == 1, expected)
    assert settings.edits.items[0].region == "mask painted"


def test_a_new_mask_shows_the_panorama_and_selects_what_is_painted(settings, core):
    assert ops.add_mask() == {"FINISHED"}
    image = settings.region.mask
    assert settings.region.kind == "MASK"
    assert tuple(image.size) == (WIDTH, HEIGHT)
    pixels = np.array(image.pixels[:]).reshape(HEIGHT, WIDTH, 4)
    assert pixels[..., :3].max() > 0.5
    assert pixels[..., 3].max() == 0
    with pytest.raises(RuntimeError, match=r"mask Spectral Probe Mask\) selects nothing"):
        ops.add_glass()
    pixels[:5] = 1
    image.pixels.foreach_set(pixels.ravel().astype(np.float32))
    ops.add_glass()
    assert np.array_equal(panorama_of(settings, core).basis_index[-5:], np.ones((5, WIDTH)))


def test_all_taken_back_is_the_probe_as_built(settings, probe_folder, core):
    built = (probe_folder / "probe.exr").read_bytes()
    ops.add_glass()
    settings.region.azimuth = math.radians(90)
    settings.region.glass = "yellow"
    ops.add_glass()
    ops.replace_lamp()
    assert names(settings) == ["red", "yellow", "LED-B3"]
    settings.edits.active_edit = 0
    ops.remove_edit()
    assert names(settings) == ["yellow", "LED-B3"]
    assert [edit.name for edit in panorama_of(settings, core).edits] == ["yellow", "LED-B3"]
    ops.remove_edit(everything=True)
    assert names(settings) == []
    assert settings.edits.state == ""
    assert (probe_folder / "probe.exr").read_bytes() == built


def test_the_world_follows(settings, scene, probe_folder):
    ops.light_world(rotation=0.5)
    placed = world_image(scene)
    strength = scene.world.node_tree.nodes["Spectral Probe Light"].inputs["Strength"].default_value
    ops.add_glass()
    image = world_image(scene)
    assert Path(image.filepath) == probe_folder / "edits" / settings.edits.state / "world.exr"
    lit = np.array(image.pixels[:]).reshape(HEIGHT, WIDTH, 4)[::-1]
    window = lit[..., 0].argmax(), lit[..., 2].argmax()
    assert window[0] >= 0
    red = lit[(lit[..., 0] > 3 * lit[..., 2]) & (lit[..., 0] > 0)]
    assert len(red) > 10
    nodes = scene.world.node_tree.nodes
    assert nodes["Spectral Probe Light"].inputs["Strength"].default_value == strength
    assert nodes["Spectral Probe Rotation"].inputs["Rotation"].default_value[2] == pytest.approx(0.5)
    ops.remove_edit()
    assert world_image(scene) == placed


def test_a_world_of_ones_own_is_left_alone(settings, scene):
    world = scene.world
    ops.add_glass()
    assert scene.world == world
    assert names(settings) == ["red"]


def test_light_world_takes_the_edited_light(settings, scene):
    ops.add_glass()
    ops.light_world()
    assert settings.edits.state in world_image(scene).filepath


def test_undo_and_redo(settings, scene, core):
    ops.light_world()
    bpy.ops.ed.undo_push(message="before")
    ops.add_glass("EXEC_DEFAULT", True)
    state = bpy.context.scene.spectral_probe.edits.state
    assert state
    bpy.ops.ed.undo()
    settings = bpy.context.scene.spectral_probe
    assert names(settings) == []
    assert panorama_of(settings, core).edits == ()
    assert "edits" not in world_image(bpy.context.scene).filepath
    bpy.ops.ed.redo()
    settings = bpy.context.scene.spectral_probe
    assert names(settings) == ["red"]
    assert settings.edits.state == state
    assert len(panorama_of(settings, core).edits) == 1
    assert state in world_image(bpy.context.scene).filepath
    assert scene is not None


def test_another_probe_folder_has_its_own_light(settings, probe_folder, tmp_path, in_extension):
    ops.add_glass()
    folder_of = in_extension("operators.settings").probe_folder
    assert folder_of(settings) == probe_folder / "edits" / settings.edits.state
    settings.probe_directory = str(tmp_path / "other")
    assert folder_of(settings) == tmp_path / "other"


def test_edits_made_on_the_command_line_are_taken_over(settings, probe_folder, core):
    edits, files = core("spectra.edits"), core("files.probe_exr")
    panorama = files.read_probe(probe_folder / "probe.exr")
    mask = np.zeros((HEIGHT, WIDTH), bool)
    mask[10:20, 5:20] = True
    panorama = edits.apply_edit(panorama, edits.glass_edit(panorama, "green", "a box"), mask)
    files.write_probe(probe_folder / "probe.exr", panorama)
    ops.add_glass()
    assert names(settings) == ["green", "red"]
    ops.remove_edit(everything=True)
    assert panorama_of(settings, core).edits == ()
    assert panorama_of(settings, core).basis_index.max() == 0


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda region: setattr(region, "glass", "rred"), 'There is no glass "rred". Did you mean "red"'),
        (lambda region: setattr(region, "glass_path", "/lost.csv"), "There is no file /lost.csv"),
        (lambda region: setattr(region, "kind", "POLYGON"), "Give the corners of the polygon first"),
        (lambda region: setattr(region, "kind", "MASK"), "Choose or make a mask first"),
    ],
)
def test_what_is_wrong_is_reported_and_changes_nothing(settings, probe_folder, spoil, message):
    spoil(settings.region)
    with pytest.raises(RuntimeError, match=message):
        ops.add_glass()
    assert names(settings) == []
    assert not (probe_folder / "edits").exists()


@pytest.mark.parametrize(
    ("polygon", "message"),
    [
        ("1,2; 3", '"3" is no corner'),
        ("1,2; 3,4", "three corners or more"),
        ("1,99; 3,4; 5,6", "elevation 99"),
    ],
)
def test_polygons_that_are_none(settings, polygon, message):
    settings.region.kind, settings.region.polygon = "POLYGON", polygon
    with pytest.raises(RuntimeError, match=message):
        ops.add_glass()


def test_a_mask_of_the_wrong_shape(settings):
    settings.region.kind = "MASK"
    settings.region.mask = bpy.data.images.new("square", 16, 16)
    with pytest.raises(RuntimeError, match="The mask square is 16 x 16 pixels"):
        ops.add_glass()


@pytest.mark.parametrize("verb", ["add_glass", "replace_lamp", "add_mask", "remove_edit"])
@pytest.mark.usefixtures("scene")
def test_grey_buttons_say_why(verb):
    with pytest.raises(RuntimeError, match="Build the probe first"):
        getattr(ops, verb)()


@pytest.mark.usefixtures("settings")
def test_nothing_to_take_back():
    with pytest.raises(RuntimeError, match="Add a glass or a lamp first"):
        ops.remove_edit()


def test_the_panel(settings, drawn, capfd):
    ops.add_glass()
    for kind in ("SEED", "POLYGON", "MASK"):
        settings.region.kind = kind
        widgets = drawn(bpy.types.SPECTRAL_PROBE_PT_edits)
        called = [widget["operator"] for widget in widgets if widget.get("operator")]
        for verb in ("add_glass", "replace_lamp", "remove_edit"):
            assert any(f"spectral_probe.{verb}(" in text for text in called), (kind, verb)
        assert "grown from 0,10" in [widget.get("draw_string", "") for widget in widgets]
    assert "not found" not in "".join(capfd.readouterr())


def test_search_fields(in_extension):
    properties = in_extension("settings.region")
    assert "red" in properties.glass_names(None, bpy.context, "re")
    assert "LED-B3" in dict(properties.lamp_names(None, bpy.context, "led-b"))


def test_renders_get_the_edited_light(settings, core, in_extension):
    ops.add_glass()
    settings.region.azimuth = math.radians(90)
    ops.replace_lamp()
    edited = panorama_of(settings, core)
    assert len(edited.bases) == 3
    spectra = np.einsum("hwk,hwkl->hwl", edited.weights, edited.bases[edited.basis_index])
    light = in_extension("operators.bridge.light")
    by_wavelength = light.WavelengthLight(edited, light.light_level(edited), [])
    reference = core("render.plan").reference_plan()
    held = np.searchsorted(reference.grid_nm, reference.wavelengths_nm[3])
    assert by_wavelength.pixels(reference, 3) * by_wavelength.level == pytest.approx(
        spectra[..., held], rel=1e-4
    )
    (only,) = core("render.light_sets").light_sets(edited, reflectances=np.ones((1, 61)), max_de2000=0.5)
    layers = only.layers
    assert layers.residual < 1e-6  # daylight, the same behind a glass, and an LED: three kinds of light
    assert layers.weights @ layers.spectra == pytest.approx(spectra, rel=1e-3, abs=1e-3 * spectra.max())
    colours = core("spectra.colorimetry")
    expected = np.maximum(colours.xyz_to_rec709(colours.panorama_xyz(edited)), 0)
    assert light.panorama_rec709(edited) == pytest.approx(expected, rel=1e-4, abs=1e-3)


@pytest.mark.parametrize(("azimuth", "elevation"), [(0, 0), (90, 20), (200, -40), (359, 60)])
@pytest.mark.parametrize("turn", [0.0, 0.5])
def test_the_direction_that_a_view_looks_in(in_extension, core, azimuth, elevation, turn):
    from mathutils import Vector

    bearing_of_view = in_extension("operators.seed_from_view").bearing_of_view
    direction = Vector(core("geometry.frames").bearing_to_direction(azimuth, elevation))
    view = direction.to_track_quat("-Z", "Y")
    found = np.degrees(bearing_of_view(view, (0.0, 0.0, turn)))
    # A panorama turned counter-clockwise by an angle shows, in a fixed direction, what has a bearing greater by it.
    assert (found[0] - azimuth - math.degrees(turn) + 180) % 360 - 180 == pytest.approx(0, abs=1e-3)
    assert found[1] == pytest.approx(elevation, abs=1e-3)


def test_the_seed_is_taken_from_a_viewport(settings, in_extension):
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    region = next(region for region in area.regions if region.type == "WINDOW")
    settings.region.kind = "POLYGON"
    with bpy.context.temp_override(window=window, area=area, region=region):
        view = area.spaces.active.region_3d.view_rotation.copy()
        assert ops.seed_from_view() == {"FINISHED"}
    expected = in_extension("operators.seed_from_view").bearing_of_view(view, (0.0, 0.0, 0.0))
    assert (settings.region.azimuth, settings.region.elevation) == pytest.approx(expected)
    assert settings.region.kind == "SEED"


def test_the_view_gives_other_panels_their_direction(settings):
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    region = next(region for region in area.regions if region.type == "WINDOW")
    known = settings.known_light
    with bpy.context.temp_override(window=window, area=area, region=region):
        ops.seed_from_view()
        expected = pytest.approx((settings.region.azimuth, settings.region.elevation))
        ops.seed_from_view(target="SPECTRUM")
        ops.seed_from_view(target="CALIBRATION")
        with pytest.raises(RuntimeError, match="Add one in Lamps by Region"):
            ops.seed_from_view(target="LIGHT")
        light = known.regions.add()
        light.place = "POLYGON"
        ops.seed_from_view(target="LIGHT")
    assert (settings.spectrum.azimuth, settings.spectrum.elevation) == expected
    assert (known.calibration.bearing, known.calibration.elevation) == expected
    assert (light.place, light.bearing, light.elevation) == (
        "SEED",
        settings.region.azimuth,
        settings.region.elevation,
    )


@pytest.mark.usefixtures("settings")
def test_the_seed_needs_a_viewport():
    window = bpy.context.window_manager.windows[0]
    viewports = [area for area in window.screen.areas if area.type == "VIEW_3D"]
    for area in viewports:
        area.type = "TEXT_EDITOR"
    try:
        with (
            bpy.context.temp_override(window=window),
            pytest.raises(RuntimeError, match="Open a 3D viewport in this window"),
        ):
            ops.seed_from_view()
    finally:
        for area in viewports:
            area.type = "VIEW_3D"


def test_beside_the_properties_the_seed_is_from_the_viewport_of_the_window(settings, in_extension):
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "PROPERTIES")
    viewport = next(area for area in window.screen.areas if area.type == "VIEW_3D").spaces.active.region_3d
    with bpy.context.temp_override(window=window, area=area, region=area.regions[0]):
        assert ops.seed_from_view() == {"FINISHED"}
    expected = in_extension("operators.seed_from_view").bearing_of_view(
        viewport.view_rotation, (0.0, 0.0, 0.0)
    )
    assert (settings.region.azimuth, settings.region.elevation) == pytest.approx(expected)
