"""Swappable regions and the exchange of their light in Blender: what the operators do is what the functions do."""

import json
import math

import bpy
import numpy as np
import pytest

ops = bpy.ops.spectral_probe
SIZE = (6, 8)


@pytest.fixture
def core(in_extension):
    """Modules of the extension's own core."""
    return lambda name: in_extension(f"spectral_probe.{name}")


@pytest.fixture
def rendered(settings, tmp_path, core):
    """The folder of a render with a swappable window: one pass of one layer."""
    data, images = core("render_model"), core("files.image_exr")
    interpolation, spectrum = np.ones((1, 61)), np.full(61, 0.5)
    plan = data.PassPlan(
        kind="light-basis",
        wavelengths_nm=np.full((1, 3), 550.0),
        reconstruction=np.stack([spectrum, np.zeros(61), np.zeros(61)])[None],
        grid_nm=core("spectra.grid").WAVELENGTHS_NM.copy(),
        sample_shares=np.ones(1),
        references=(0,),
        light_sets=(0,),
        interpolation=interpolation,
        swappable=(data.SwappableLayer("window", 0, 0, spectrum),),
    )
    core("render.plan_file").save_plan(plan, tmp_path / "plan.json")
    one, none = np.ones(SIZE, np.float32), np.zeros(SIZE, np.float32)
    planes = {f"fixed.{axis}": none for axis in "XYZ"}
    images.write_channels(tmp_path / "swappable.exr", {**planes, "layer0.pass0": one})
    xyz = core("render.swap").swapped_xyz(tmp_path, plan, {})
    images.write_rgb(tmp_path / "xyz.exr", xyz, "XYZ")
    images.write_rgb(tmp_path / "image.exr", xyz)
    (tmp_path / "report.json").write_text("{}")
    settings.render_directory = str(tmp_path)
    return tmp_path


def xyz_of(folder, core):
    return core("files.image_exr").read_rgb(folder / "xyz.exr", ("X", "Y", "Z"))


def test_swapping_gives_what_the_function_gives(settings, rendered, core):
    swap = settings.swap
    swap.light, swap.kind, swap.glass = "window", "GLASS", "red"
    red = core("spectra.glass").glass_transmittance("red")
    expected = core("render.swap").swap(rendered, "window", red, "glass")
    before = xyz_of(rendered, core)
    assert ops.swap_light() == {"FINISHED"}
    np.testing.assert_array_equal(xyz_of(rendered, core), expected)
    assert (rendered / "preview.png").is_file()
    assert swap.lights == "window\tglass red"
    assert json.loads((rendered / "report.json").read_text())["lights"] == {"window": "glass red"}
    swap.kind, swap.lamp = "LAMP", "HP1"
    assert ops.swap_light() == {"FINISHED"}
    np.testing.assert_allclose(xyz_of(rendered, core)[..., 1], before[..., 1], rtol=1e-5)
    assert swap.lights == "window\tlamp HP1"
    swap.kind = "ORIGINAL"
    assert ops.swap_light() == {"FINISHED"}
    np.testing.assert_allclose(xyz_of(rendered, core), before, rtol=1e-6)


@pytest.mark.usefixtures("rendered")
def test_an_unknown_light_is_reported(settings):
    settings.swap.light = "door"
    with pytest.raises(RuntimeError, match=r'no swappable light "door" in this render\. It has window'):
        ops.swap_light()


def test_the_button_is_grey_before_there_is_a_render(settings, tmp_path):
    settings.render_directory = str(tmp_path)
    assert not ops.swap_light.poll()


def test_regions_are_marked_and_unmarked(settings):
    assert not ops.remove_swappable.poll()
    settings.region.azimuth, settings.region.elevation = math.radians(30), math.radians(10)
    assert ops.add_swappable() == {"FINISHED"}
    settings.region.kind, settings.region.polygon = "POLYGON", "0 0, 20 0, 20 20"
    assert ops.add_swappable() == {"FINISHED"}
    first, second = settings.swap.items
    assert (first.name, first.kind, round(math.degrees(first.azimuth))) == ("light 1", "SEED", 30)
    assert (second.name, second.kind, second.polygon) == ("light 2", "POLYGON", "0 0, 20 0, 20 20")
    settings.swap.active_item = 0
    assert ops.remove_swappable() == {"FINISHED"}
    assert [item.name for item in settings.swap.items] == ["light 2"]
    assert ops.add_swappable() == {"FINISHED"}
    assert {item.name for item in settings.swap.items} == {"light 1", "light 2"}


def test_a_region_that_is_none_is_not_marked(settings):
    settings.region.kind, settings.region.polygon = "POLYGON", "0 0, 20 0"
    with pytest.raises(RuntimeError, match="three corners"):
        ops.add_swappable()
    assert not settings.swap.items


def test_marked_regions_are_masks_of_the_panorama(settings, core, in_extension):
    size = (16, 32)
    panorama = core("model").SpectralPanorama(
        np.ones((*size, 1), np.float32),
        np.ones((1, 1, 61)),
        np.zeros(size, np.uint8),
        core("spectra.grid").WAVELENGTHS_NM,
        np.ones(size, bool),
        np.ones(size, np.float32),
    )
    settings.region.kind, settings.region.polygon = "POLYGON", "-20 -20, 20 -20, 20 20, -20 20"
    ops.add_swappable()
    settings.swap.items[0].name = "window"
    masks = in_extension("operators.add_swappable").marked_masks(settings, panorama)
    assert list(masks) == ["window"]
    assert 0 < masks["window"].mean() < 0.1
    ops.add_swappable()
    settings.swap.items[1].name = "window"
    errors = core("errors")
    with pytest.raises(errors.RenderError, match="Two swappable regions"):
        in_extension("operators.add_swappable").marked_masks(settings, panorama)


def test_a_plan_is_kept_for_the_panel(settings, core, in_extension):
    plan = core("render.plan").reference_plan()
    in_extension("operators.results").keep_plan(settings, plan)
    planned = settings.planned
    assert (planned.kind, planned.passes, planned.cost, planned.max_de2000) == ("Wavelengths", 21, 21.0, 0.0)
    assert "21 RGB renders" in planned.text


def test_all_wavelengths_and_a_swappable_lamp_contradict_each_other(in_extension):
    request = in_extension("operators.bridge.planning").PlanRequest
    with pytest.raises(in_extension("spectral_probe.errors").RenderError, match="no light layers"):
        request("all", lamps_swappable=True)
    assert request("all").light_basis


def test_the_plan_is_that_of_the_render(scene, settings, tmp_path, core, in_extension):
    """The default cube, in daylight, with a window that is to be exchanged: said before anything is rendered."""
    size = (16, 32)
    weights = np.full((*size, 1), 0.1, np.float32)
    weights[4:8, 4:8] = 5.0
    panorama = core("model").SpectralPanorama(
        weights,
        core("spectra.library").daylight(6500.0)[None, None],
        np.zeros(size, np.uint8),
        core("spectra.grid").WAVELENGTHS_NM,
        np.ones(size, bool),
        np.ones(size, np.float32),
    )
    core("model").finish(core("editing")._write_light(panorama, tmp_path / "probe"))
    settings.probe_directory = str(tmp_path / "probe")
    assert not ops.plan_render.poll()  # EEVEE
    scene.render.engine = "CYCLES"
    for lamp in [thing for thing in scene.objects if thing.type == "LIGHT"]:
        bpy.data.objects.remove(lamp)
    settings.plan, settings.passes, settings.samples = "NUMBER", 4, 64
    assert ops.plan_render() == {"FINISHED"}
    alone = settings.planned.cost
    row, column = 6, 6
    bearing = (90.0 - np.degrees(np.pi * (1 - 2 * (column + 0.5) / size[1]))) % 360.0
    settings.region.kind, settings.region.azimuth = "SEED", math.radians(bearing)
    settings.region.elevation = math.radians(90.0 - 180.0 * (row + 0.5) / size[0])
    ops.add_swappable()
    assert ops.plan_render() == {"FINISHED"}
    planned = settings.planned
    assert (planned.kind, planned.passes) == ("Light layers", 8)
    assert planned.cost > alone
    assert "exchanged" in planned.text
    probe = core("files.probe_exr").read_probe(tmp_path / "probe" / "probe.exr")
    masks = in_extension("operators.add_swappable").marked_masks(settings, probe)
    planning = in_extension("operators.bridge.planning")
    planner = planning.Planner(probe, planning.PlanRequest(4, swappable=masks), 64)
    plan = in_extension("operators.bridge.cycles").planned(scene, planner)
    assert planned.cost == pytest.approx(plan.predicted_cost)
    assert planned.text == "\n".join(core("render.plan").describe(plan))
