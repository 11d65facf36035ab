"""The panorama tools without a window: what the operators keep is what the functions give, and undo and files are followed."""

import math
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

ops = bpy.ops.spectral_probe
HEIGHT, WIDTH = 32, 64


@pytest.fixture
def core(in_extension):
    return lambda name: in_extension(f"spectral_probe.{name}")


@pytest.fixture(autouse=True)
def memory(in_extension):
    memory = in_extension("operators.bridge.opened_probe").MEMORY
    memory.forget()
    yield memory
    memory.forget()


@pytest.fixture(autouse=True)
def settings(scene, tmp_path, core):
    """A probe of a daylight window at bearing 90 in a dim room; what lies below -60 degrees was not seen."""
    frames = core("geometry.frames")
    directions = frames.panorama_directions(HEIGHT, WIDTH)
    level = np.full((HEIGHT, WIDTH), 0.05, np.float32)
    level[directions @ frames.bearing_to_direction(90, 10) > math.cos(math.radians(15))] = 1
    panorama = core("model").SpectralPanorama(
        level[..., None],
        core("spectra.library").daylight(6500.0)[None, None],
        np.zeros((HEIGHT, WIDTH), np.uint8),
        core("spectra.grid").WAVELENGTHS_NM,
        directions[..., 2] > -0.86,
        np.full((HEIGHT, WIDTH), 0.9, np.float32),
    )
    core("model").finish(core("editing")._write_light(panorama, tmp_path / "probe"))
    scene.spectral_probe.probe_directory = str(tmp_path / "probe")
    return scene.spectral_probe


@pytest.fixture
def shown():
    return bpy.context.window_manager.spectral_probe_panorama


def spectrum_at(settings, core, azimuth_deg, elevation_deg):
    panorama = core("files.probe_exr").read_probe(
        core("editing").Path(settings.probe_directory) / "probe.exr"
    )
    return core("spectrum_command").spectrum_at(panorama, azimuth_deg, elevation_deg, 0.5)


def test_pick_direction_gives_what_the_function_gives(settings, shown, core):
    assert ops.pick_direction(azimuth=math.radians(90), elevation=math.radians(10)) == {"FINISHED"}
    found = spectrum_at(settings, core, 90.0, 10.0)
    values = np.array([(p.wavelength_nm, p.radiance, p.lower, p.upper) for p in shown.points])
    expected = np.stack([found.wavelengths_nm, found.spectrum, *found.band_95], axis=-1)
    assert values == pytest.approx(expected, rel=1e-5, abs=1e-6)
    assert shown.confidence == pytest.approx(0.9)
    assert math.degrees(settings.spectrum.azimuth) == pytest.approx(90)
    assert settings.spectrum.has_numbers
    assert settings.spectrum.cct_kelvin == pytest.approx(6500, rel=0.01)


def test_a_direction_that_no_view_saw_is_told_and_leaves_no_curve(shown):
    ops.pick_direction(azimuth=0.0, elevation=0.1)
    assert len(shown.points) == 61
    assert ops.pick_direction(azimuth=0.0, elevation=math.radians(-80)) == {"FINISHED"}
    assert len(shown.points) == 0
    assert "No view saw" in shown.problem


@pytest.mark.parametrize("target", ["SPECTRUM", "EDIT", "LIGHT", "CALIBRATION", "COMPARE", "SWAP"])
def test_a_direction_goes_where_it_is_for(settings, target):
    known = settings.known_light
    group, names = {
        "SPECTRUM": (settings.spectrum, "azimuth"),
        "EDIT": (settings.region, "azimuth"),
        "LIGHT": (known.regions.add(), "bearing"),
        "CALIBRATION": (known.calibration, "bearing"),
        "COMPARE": (settings.compare, "azimuth"),
        "SWAP": (settings.swap.items.add(), "azimuth"),
    }[target]
    ops.pick_direction(target=target, azimuth=1.25, elevation=-0.5)
    assert (getattr(group, names), group.elevation) == pytest.approx((1.25, -0.5))
    if target == "COMPARE":
        assert group.light == "DIRECTION"


@pytest.mark.parametrize("operator", ["pick_direction", "draw_region"])
def test_a_region_that_is_not_there_yet_is_told(operator):
    words = {} if operator == "pick_direction" else {"corners": "10 0, 30 0, 30 20"}
    with pytest.raises(RuntimeError, match=r"There is no region yet\. Add one in Swap first"):
        getattr(ops, operator)(target="SWAP", **words)


@pytest.mark.parametrize(
    ("target", "field"), [("EDIT", "polygon"), ("LIGHT", "polygon_deg"), ("SWAP", "polygon")]
)
def test_draw_region_writes_the_corners_into_their_field(settings, target, field, in_extension):
    settings.known_light.regions.add()
    settings.swap.items.add()
    group = {
        "EDIT": settings.region,
        "LIGHT": settings.known_light.regions[0],
        "SWAP": settings.swap.items[0],
    }[target]
    assert ops.draw_region(target=target, corners="350.004 5; -350,5; 5,25") == {"FINISHED"}
    assert getattr(group, field) == "350.00 5.00, 10.00 5.00, 5.00 25.00"
    assert getattr(group, "place" if target == "LIGHT" else "kind") == "POLYGON"
    corners = in_extension("operators.typed").corners_of(getattr(group, field))
    assert corners == ((350.0, 5.0), (10.0, 5.0), (5.0, 25.0))


@pytest.mark.parametrize(
    ("corners", "message"),
    [
        ("10 5, 20 5", "three corners"),
        ("10 5, x", "is no corner"),
        ("0 0, 180 0, 90 40", "lie opposite each other"),
    ],
)
def test_draw_region_refuses_what_is_no_polygon(settings, corners, message):
    with pytest.raises(RuntimeError, match=message):
        ops.draw_region(corners=corners)
    assert settings.region.polygon == ""


def test_a_drawn_region_takes_a_glass_chosen_from_the_list(settings, memory, in_extension):
    ops.draw_region(corners="80 0, 100 0, 100 20, 80 20")
    assert ops.choose_glass(glass="red") == {"FINISHED"}
    assert [edit.name for edit in settings.edits.items] == ["red"]
    path = in_extension("operators.settings").probe_folder(settings) / "probe.exr"
    held = memory.peek(path)  # nothing has to be read again, and its outline is there
    outline = held.outlines[0]
    assert len(held.outlines) == 1
    assert outline[..., 0].min() == pytest.approx(80 / 360 + 0.25, abs=1 / WIDTH)
    assert outline[..., 1].max() == pytest.approx(0.5 + 20 / 180, abs=1 / HEIGHT)
    assert ops.choose_lamp(lamp="LED-B3") == {"FINISHED"}
    assert [edit.kind for edit in settings.edits.items] == ["glass", "lamp"]


def image():
    return bpy.data.images.get("Spectral Probe Panorama")


def shown_file():
    return core_path(image().filepath)


def core_path(text):
    from pathlib import Path

    return Path(bpy.path.abspath(text))


@pytest.mark.parametrize(("picture", "file"), [("LIGHT", "preview.png"), ("CONFIDENCE", "confidence.png")])
def test_show_panorama_shows_a_picture_of_the_probe(settings, picture, file, in_extension):
    assert ops.show_panorama(picture=picture) == {"FINISHED"}
    assert shown_file() == core_path(settings.probe_directory) / file
    assert in_extension("operators.bridge.panorama_image").picture_of(image()) == picture


def test_kinds_of_light_that_the_probe_does_not_tell():
    with pytest.raises(RuntimeError, match="does not tell how its light was recovered"):
        ops.show_panorama(picture="KINDS")


def test_the_picture_follows_edits_and_undo(settings):
    settings.region.azimuth, settings.region.elevation = math.radians(90), math.radians(10)
    ops.show_panorama(picture="CONFIDENCE")
    ops.show_panorama(picture="LIGHT")
    before = np.array(image().pixels[:])
    bpy.ops.ed.undo_push(message="shown")
    ops.add_glass()
    bpy.ops.ed.undo_push(message="glass")
    edited = shown_file()
    assert edited.parent.parent.name == "edits"
    after = np.array(image().pixels[:])
    assert np.abs(after - before).max() > 0.1
    bpy.ops.ed.undo()
    assert shown_file() == core_path(bpy.context.scene.spectral_probe.probe_directory) / "preview.png"
    assert np.array_equal(np.array(image().pixels[:]), before)
    bpy.ops.ed.redo()
    assert shown_file() == edited
    assert np.array_equal(np.array(image().pixels[:]), after)


def test_a_probe_is_read_once_and_again_when_its_file_changed(memory, tmp_path, core):
    path = tmp_path / "probe" / "probe.exr"
    first = memory.read(path)
    assert memory.read(path) is first
    panorama = first.panorama
    core("files.probe_exr").write_probe(
        path, core("model").SpectralPanorama(**{**vars(panorama), "confidence": panorama.confidence * 0})
    )
    assert memory.read(path).panorama.confidence.max() == 0
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert memory.peek(path) is None


def test_the_mouse_finds_the_direction_whatever_lies_below_the_panorama(in_extension):
    """The image editor's own conversion, for a picture with a legend below it."""
    module = in_extension("operators.bridge.panorama_image")
    zoom, left, bottom = 2.5, 40.0, -30.0

    def region_to_view(x, y):  # as Blender: what it draws at the region's edge lies at the last pixel's index
        return (x * 640 / 639 - left) / (200 * zoom), (y * 480 / 479 - bottom) / (120 * zoom)

    region = SimpleNamespace(width=640, height=480, view2d=SimpleNamespace(region_to_view=region_to_view))
    view = module.view_in(region, SimpleNamespace(size=(200, 120)))
    assert view.bearing_at(left + 100 * zoom, bottom + (20 + 50) * zoom) == pytest.approx((90.0, 0.0))
    assert view.bearing_at(left + 100 * zoom, bottom + (20 + 99.99) * zoom)[1] == pytest.approx(90, abs=0.1)
    assert view.bearing_at(left + 100 * zoom, bottom + 19 * zoom) is None  # the legend
    assert view.placed(np.array([0.5, 0.5])) == pytest.approx([left + 100 * zoom, bottom + 70 * zoom])


def test_handlers_are_there_once_and_gone_after(in_extension):
    handlers = in_extension("operators.panorama_handlers")
    handlers.register()
    ours = [h for h in bpy.app.handlers.undo_post if h.__name__ == "follow_undo"]
    assert len(ours) == 1
    handlers.unregister()
    assert not [h for h in bpy.app.handlers.undo_post if h.__name__ == "follow_undo"]
    handlers.register()


@pytest.mark.parametrize("name", ["panorama", "pick", "region", "other_regions"])
def test_the_panels_draw(drawn, name):
    ops.pick_direction(azimuth=math.radians(90), elevation=math.radians(10))
    assert drawn(getattr(bpy.types, f"SPECTRAL_PROBE_PT_{name}"))
