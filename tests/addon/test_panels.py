"""Panels draw every stage, show results, and name only properties and operators that exist."""

import bpy
import pytest

PANELS = (
    "main", "capture", "photographs", "camera", "ball", "probe", "plots", "edits", "lamps", "region_lights", "calibration",
    "world", "backplate", "ground", "objects", "render", "swap", "composite", "compare",
)  # fmt: skip


pytestmark = pytest.mark.usefixtures("scene")


def panel(name):
    return getattr(bpy.types, f"SPECTRAL_PROBE_PT_{name}")


def texts(widgets):
    return [widget.get("draw_string", "") for widget in widgets]


def operators(widgets):
    return [widget["operator"] for widget in widgets if widget.get("operator")]


@pytest.fixture
def filled(settings):
    """Settings with something in every place."""
    for number in range(2):
        view = settings.views.add()
        view.name = f"view {number}"
        photo = view.photos.add()
        photo.path, photo.exposure_s = f"/photos/v{number}.dng", 0.004
        view.has_outline = view.has_probe = True
        view.found_centre_px, view.found_semi_axes_px, view.found_rms_px = (
            (400.25, 300.0),
            (210.5, 210.1),
            0.123,
        )
        view.probe_rms_px, view.clipped_fraction = 0.321, 0.015
    settings.capture_path = "/photos/capture.toml"
    known = settings.known_light
    known.own_lights.add().path = "/lamps/mine.csv"
    known.regions.add().name = "Region 1"
    known.calibration.source = "PATCH"
    known.calibration.has_ball_patch = True
    settings.probe.width_px, settings.probe.height_px = 1024, 512
    settings.probe.blind_fraction, settings.probe.seconds = 0.0123, 8.25
    shown = settings.spectrum
    shown.has_numbers, shown.has_comparison, shown.confidence = True, True, 0.9846
    shown.cct_kelvin, shown.duv, shown.ra, shown.rf = 4224.2, -0.00182, 64.2, 70.1
    shown.gfc, shown.relative_rmse, shown.de2000_light = 0.99996, 0.0312, 1.234
    settings.render.passes, settings.render.samples = 5, 64
    settings.render.seconds, settings.render.has_rgb, settings.render.rgb_seconds = 75.0, True, 12.0
    settings.swap.items.add().name = "window"
    settings.swap.lights, settings.swap.light = "window\tas rendered\ndesk\tlamp FL11", "window"
    planned = settings.planned
    planned.kind, planned.passes, planned.cost, planned.text = (
        "Light layers",
        5,
        1.25,
        "5 passes.\nWavelengths.",
    )
    planned.mean_de2000, planned.max_de2000 = 0.06, 0.45
    plate = settings.backplate
    plate.matched, plate.aligned, plate.shift_px, plate.error_px = "{}", True, (0.25, -1.5), 0.031
    plate.reduce, plate.on_ground, plate.exposure_s, plate.ground_source = True, False, 0.01, "GIVEN"
    plate.gain, plate.ground_mean, plate.remarks = (
        (1.0, 0.98, 1.25),
        (0.3, 0.2, 0.1),
        "It had another white balance.",
    )
    settings.comparison.directory, settings.comparison.mean_de2000 = "/render/comparison", 1.234
    settings.comparison.warnings = "A pixel was left out."
    settings.compare.light = "DIRECTION"
    ball = settings.compare.objects.add()
    ball.name, ball.mean_de2000, ball.p95_de2000 = "Copper Ball", 2.345, 4.567
    return settings


@pytest.mark.parametrize("name", PANELS)
@pytest.mark.parametrize("state", ["empty", "filled"])
def test_every_widget_has_its_property(name, state, drawn, request, capfd):
    if state == "filled":
        request.getfixturevalue("filled")
    assert drawn(panel(name)) or (name, state) == ("photographs", "empty")
    written = "".join(capfd.readouterr())
    assert "not found" not in written, written


@pytest.mark.parametrize(
    ("name", "verbs"),
    [
        ("capture", ["import_photographs", "save_capture", "add_view", "remove_view"]),
        ("photographs", ["add_photos", "remove_photo"]),
        ("camera", ["calibrate"]),
        ("lamps", ["add_own_light", "remove_own_light"]),
        ("region_lights", ["add_region_light", "remove_region_light", "seed_from_view"]),
        ("ball", ["detect_ball", "show_photograph"]),
        ("probe", ["build_probe"]),
        ("plots", ["seed_from_view", "show_spectrum", "show_basis", "show_confidence", "show_sensitivities"]),
        ("world", ["light_world"]),
        ("backplate", ["match_backplate"]),
        ("ground", ["add_ground"]),
        ("objects", [*4 * ["add_object"], "add_asset_library"]),
        ("render", ["use_cycles", "plan_render", "render_spectral", "render_animation", "export_farm_job"]),
        ("swap", ["add_swappable", "remove_swappable", "swap_light"]),
        ("composite", ["composite"]),
        ("compare", ["compare", *5 * ["show_comparison"]]),
    ],
)
@pytest.mark.usefixtures("filled")
def test_each_stage_has_its_buttons(name, verbs, drawn):
    called = [text for text in operators(drawn(panel(name))) if text.startswith("bpy.ops.spectral_probe.")]
    assert [text.removeprefix("bpy.ops.spectral_probe.").split("(")[0] for text in called] == verbs


@pytest.mark.parametrize(
    ("name", "results"),
    [
        ("ball", ["400.2, 300.0 px", "210.50, 210.10 px", "0.123 px"]),
        ("probe", ["1024 x 512 px", "1.23%", "8.2 s", "0.32 px", "1.5%"]),
        ("plots", ["0.985", "4224 K", "-0.0018", "64, 70", "0.9999", "3.1%", "1.23"]),
        ("render", ["5 at 64 samples", "1 min 15 s", "12.0 s"]),
        ("backplate", ["+0.25, -1.50 px", "0.03 px", "1.00, 0.98, 1.25", "0.30, 0.20, 0.10"]),
        ("compare", ["1.23", "Copper Ball", "2.35", "4.57"]),
    ],
)
@pytest.mark.usefixtures("filled")
def test_results_are_shown(name, results, drawn):
    shown = texts(drawn(panel(name)))
    assert [result for result in results if result not in shown] == []


def test_results_are_hidden_before_there_are_any(drawn):
    assert "Blind" not in texts(drawn(panel("probe")))
    assert "CCT" not in texts(drawn(panel("plots")))
    assert not [text for text in texts(drawn(panel("compare"))) if "ΔE" in text]


@pytest.mark.parametrize(
    ("name", "verb"),
    [
        ("ball", "detect_ball"),
        ("probe", "build_probe"),
        ("plots", "show_spectrum"),
        ("plots", "show_confidence"),
        ("render", "render_spectral"),
        ("compare", "compare"),
    ],
)
def test_a_running_job_shows_its_progress_in_place_of_its_button(name, verb, drawn):
    running = bpy.context.window_manager.spectral_probe
    running.operator, running.fraction, running.message = f"spectral_probe.{verb}", 0.4, "View 2 of 3"
    try:
        assert "View 2 of 3" in texts(drawn(panel(name)))
        assert not [called for called in operators(drawn(panel(name))) if f".{verb}(" in called]
    finally:
        bpy.context.window_manager.property_unset("spectral_probe")
    assert "View 2 of 3" not in texts(drawn(panel(name)))


def test_a_long_message_is_broken_into_lines_under_the_bar(drawn):
    """A progress bar leaves out the middle of a text that is too long for it."""
    message = "Pass 2 of 4: 475, 525, 605 nm, 64 of 256 samples, about 8 s left"
    running = bpy.context.window_manager.spectral_probe
    running.operator, running.fraction, running.message = "spectral_probe.match_backplate", 0.25, message
    try:
        shown = texts(drawn(panel("backplate")))
    finally:
        bpy.context.window_manager.property_unset("spectral_probe")
    bar = shown.index("25%")
    lines = shown[bar + 1 : bar + 5]
    assert message.startswith(" ".join(lines))
    assert max(map(len, lines)) <= 20  # a sidebar that was never drawn has the least width


@pytest.mark.parametrize(
    ("kind", "wanted"), [("RGB", None), ("METAL", "metal"), ("REFLECTANCE", "reflectance_path")]
)
def test_the_material_panel_asks_for_what_its_kind_needs(kind, wanted, drawn):
    material = bpy.data.materials["Material"]
    material.spectral_probe.kind = kind
    widgets = drawn(panel("material"), material=material)
    named = [widget["rna"] for widget in widgets if "rna" in widget]
    fields = {rna.removeprefix("SPECTRAL_PROBE_PG_material.").removesuffix("[0]") for rna in named}
    assert fields == {"kind", "light", wanted} - {None}


def test_the_material_panel_needs_a_material(drawn):
    assert drawn(panel("material"), material=None) == []


def fields(widgets):
    return {widget["rna"].split(".")[-1].split("[")[0] for widget in widgets if "rna" in widget}


@pytest.mark.parametrize(
    ("source", "light", "shown", "hidden"),
    [
        ("NONE", "SPECTRUM", {"source"}, {"illuminant", "patch_px", "reflectance"}),
        (
            "PATCH",
            "ILLUMINANT",
            {"view", "patch_px", "illuminant", "has_ball_patch"},
            {"bearing", "absolute"},
        ),
        (
            "BALL",
            "SPECTRUM",
            {"bearing", "elevation", "spectrum", "absolute"},
            {"patch_px", "has_ball_patch"},
        ),
    ],
)
def test_calibration_asks_for_what_its_light_needs(settings, source, light, shown, hidden, drawn):
    calibration = settings.known_light.calibration
    calibration.source, calibration.light = source, light
    named = fields(drawn(panel("calibration")))
    assert shown <= named
    assert not hidden & named


@pytest.mark.parametrize(
    ("place", "field"), [("SEED", "bearing"), ("POLYGON", "polygon_deg"), ("MASK", "mask")]
)
@pytest.mark.parametrize(("light", "known"), [("FAMILIES", "families"), ("SPECTRUM", "spectrum")])
def test_regions_ask_for_their_place_and_light(settings, place, field, light, known, drawn):
    region = settings.known_light.regions.add()
    region.place, region.light = place, light
    named = fields(drawn(panel("region_lights")))
    assert {field, known} <= named
    assert not ({"bearing", "polygon_deg", "mask", "families", "spectrum"} - {field, known}) & named


def test_warnings_of_a_build_stay_in_the_panel(filled, drawn):
    said = "The sensitivities of this camera are normalised channel by channel, so the gains of its channels are lost."
    filled.probe.warnings = f"{said}\nView 2 is clipped."
    shown = texts(drawn(panel("probe")))
    assert said in " ".join(shown)  # in several lines, one after the other
    assert said not in shown
    assert "View 2 is clipped." in shown
