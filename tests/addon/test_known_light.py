"""What is known of the light passes between capture file and settings unchanged, and lists grow and shrink."""

from pathlib import Path

import bpy
import pytest

ops = bpy.ops.spectral_probe


@pytest.fixture
def files(tmp_path):
    names = ("a.dng", "b.dng", "lamp.csv", "other.csv", "card.csv", "green.csv", "mask.png")
    for name in names:
        (tmp_path / name).write_text("400,1\n700,1\n")
    return {name: tmp_path / name for name in names}


@pytest.fixture
def captures(in_extension, files):
    """Captures that between them use every kind of known light."""
    model, light = in_extension("spectral_probe.model"), in_extension("spectral_probe.light_settings")
    views = (
        model.ViewSettings((files["a.dng"],), azimuth_deg=30.0),
        model.ViewSettings((files["b.dng"],), azimuth_deg=30.0, filter=files["green.csv"]),
        model.ViewSettings((files["b.dng"],), azimuth_deg=30.0, filter="yellow"),
    )
    regions = (
        light.RegionLight(light.Region(seed_deg=(-120.5, 10.25)), families=("daylight", "led-phosphor")),
        light.RegionLight(light.Region(mask=files["mask.png"]), spectrum=files["lamp.csv"]),
        light.RegionLight(
            light.Region(polygon_deg=((10.0, 5.0), (40.0, -5.5), (25.0, 30.0))), families=("automatic",)
        ),
    )
    card = light.CalibrationSettings(
        patch_px=(10.0, 20.5, 30.0, 40.0), view=1, spectrum=files["lamp.csv"], reflectance=files["card.csv"],
        absolute=True, ball_patch_px=(50.0, 60.0, 70.0, 80.0),
    )  # fmt: skip
    lamp = light.CalibrationSettings(light_at=(-70.25, 25.0), illuminant="FL11", reflectance=0.18)
    return (
        model.Capture(
            views, spectra=(files["lamp.csv"], files["other.csv"]), regions=regions, calibration=card
        ),
        model.Capture(views[:1], calibration=lamp),
        model.Capture(views[:1]),
    )


def test_every_capture_passes_through_and_leaves_nothing(in_extension, settings, captures):
    module = in_extension("operators.settings")
    for capture in captures:
        module.fill(settings, capture, Path("/nowhere/capture.toml"))
        assert module.capture_from(settings) == capture


def test_import_and_save_keep_it(in_extension, settings, captures, tmp_path):
    files_module = in_extension("spectral_probe.files.capture")
    files_module.save_capture(captures[0], tmp_path / "first.toml")
    assert ops.import_capture(filepath=str(tmp_path / "first.toml")) == {"FINISHED"}
    assert [view.filter for view in settings.views][2] == "yellow"
    assert ops.save_capture(filepath=str(tmp_path / "second.toml")) == {"FINISHED"}
    assert files_module.load_capture(tmp_path / "second.toml") == captures[0]


@pytest.mark.usefixtures("scene")
def test_measured_lamps_are_added_and_removed(settings, files):
    known = settings.known_light
    assert not ops.remove_own_light.poll()
    folder = str(files["lamp.csv"].parent)
    ops.add_own_light(directory=folder, files=[{"name": "lamp.csv"}, {"name": "other.csv"}])
    assert [Path(light.path).name for light in known.own_lights] == ["lamp.csv", "other.csv"]
    ops.remove_own_light()
    assert [Path(light.path).name for light in known.own_lights] == ["lamp.csv"]
    files["card.csv"].write_text("no numbers")
    with pytest.raises(RuntimeError, match=r"card\.csv"):
        ops.add_own_light(directory=folder, files=[{"name": "card.csv"}])
    with pytest.raises(RuntimeError, match="Choose at least one file"):
        ops.add_own_light(directory=folder, files=[])
    assert len(known.own_lights) == 1


@pytest.mark.usefixtures("scene")
def test_regions_are_added_and_removed(settings):
    known = settings.known_light
    assert not ops.remove_region_light.poll()
    ops.add_region_light()
    ops.add_region_light()
    assert [region.name for region in known.regions] == ["Region 1", "Region 2"]
    assert known.active_region == 1
    ops.remove_region_light()
    assert known.active_region == 0
    assert len(known.regions) == 1


def test_corners_are_numbers(in_extension, settings):
    module = in_extension("operators.settings_light")
    region = settings.known_light.regions.add()
    region.place, region.polygon_deg = "POLYGON", "10 5, forty 5"
    with pytest.raises(Exception, match=r'Region 1: "forty 5" is no corner. Write bearing and elevation'):
        module.regions_from(settings.known_light)


@pytest.mark.parametrize(
    "text",
    ["10 5, -40 5.5, 25 .5", "10,5; -40,5.5; 25,.5", "10 5; -40 5.5; 25 .5;", " 10 , 5;-40, 5.5 ; 25 .5"],
)
def test_corners_are_read_in_both_manners(in_extension, text):
    assert in_extension("operators.typed").corners_of(text) == ((10.0, 5.0), (-40.0, 5.5), (25.0, 0.5))


def test_families_of_both_lists_are_the_same(in_extension, settings):
    region = settings.known_light.regions.add()
    own, all_families = (
        group.bl_rna.properties["families"].enum_items.keys() for group in (region, settings)
    )
    assert own == all_families
    assert "FL11" in dict(in_extension("settings.known_light").lamp_names(None, bpy.context, "fl11"))


def test_the_ball_is_looked_for_without_the_filter(settings, capture_file):
    """Photographs through a filter may be too dark to show it; alone, as the active view, they are looked at."""
    assert ops.import_capture(filepath=str(capture_file)) == {"FINISHED"}
    settings.views[1].filter = "green"
    assert ops.detect_ball() == {"FINISHED"}
    assert [view.has_outline for view in settings.views] == [True, False]
    settings.active_view, settings.all_views = 1, False
    assert ops.detect_ball() == {"FINISHED"}
    assert settings.views[1].has_outline
