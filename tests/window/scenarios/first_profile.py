"""From a Blender that was never started to the comparison of a spectral and an RGB render, as an artist goes.

The zip is installed, photographs are dropped on the viewport, and the buttons of the sidebar are clicked from top to bottom.
"""

from pathlib import Path

import bpy

MODULE = "bl_ext.user_default.spectral_probe"
PERCENTAGE, SAMPLES = 5, 4
FIRST_BUTTON_PX, NEXT_BUTTON_PX = 50, 56  # below the sidebar's top; a closed report is between two buttons
ANSWER_S = 20.0


def steps(ui):
    """Each step timed, with a picture of the screen after it; words: the zip, and a folder with photographs."""
    ui.results["clicked"] = {}
    for number, step in enumerate(STEPS):
        with ui.step(step.__name__):
            yield from step(ui)
        yield 0.5
        ui.shot(f"{number}_{step.__name__}")
    yield from ui.sidebar("VIEW_3D")


def install(ui):
    """Preferences > Get Extensions > Install from Disk."""
    ui.operator(
        "extensions.package_install_files",
        "EXEC_DEFAULT",
        filepath=ui.words[0],
        repo="user_default",
        enable_on_install=True,
    )
    yield from ui.wait(lambda: MODULE in bpy.context.preferences.addons, 120, "the extension's entry")
    yield from ui.sidebar("VIEW_3D")


def drop_photographs(ui):
    """The photographs are dropped on the 3D viewport; the capture file beside them is found."""
    ui.drop(sorted(Path(ui.words[1]).glob("*.dng")), "VIEW_3D")
    yield from ui.wait_job()
    ui.results["views"] = [len(view.photos) for view in ui.scene.spectral_probe.views]


def photographs_to_light(ui):
    """The second button. The probe is coarse: what is tested is that it is built at all."""
    ui.scene.spectral_probe.probe_width = 256
    yield from press(ui, 1, "spectral_probe.light_from_photographs")
    yield from ui.wait_job()
    settings = ui.scene.spectral_probe
    ui.results["outline_rms_px"] = [round(view.found_rms_px, 3) for view in settings.views]
    ui.results["blind_fraction"] = settings.probe.blind_fraction
    ui.results["world"] = ui.scene.world.name
    ui.results["shading"] = shading(ui).type


def add_metals(ui):
    """Gold, silver and copper instead of the start-up cube, seen by the camera."""
    ui.operator("spectral_probe.add_object", kind="GROUP")
    yield 0.5
    ui.results["objects"] = sorted(thing.name for thing in ui.scene.objects)


def render_and_compare(ui):
    """The third button: a small spectral render, its RGB twin, and the sheet."""
    shading(ui).type = "SOLID"  # software OpenGL takes seconds for every drawing of the light
    ui.scene.render.resolution_percentage = PERCENTAGE
    ui.scene.spectral_probe.samples = SAMPLES
    yield 0.5
    yield from press(ui, 2, "spectral_probe.render_and_compare")
    yield from ui.wait_job()
    settings = ui.scene.spectral_probe
    ui.results["passes"] = settings.render.passes
    ui.results["mean_de2000"] = settings.comparison.mean_de2000


def press(ui, number, operator):
    """Click the guide's button of this number from 0; where a theme or font puts it elsewhere, call its operator."""
    for report in reports():
        report.opened = False
    ui.redraw()
    yield 0.2
    region = ui.region("VIEW_3D", "UI")
    x = region.x + region.width // 2
    y = region.y + region.height - FIRST_BUTTON_PX - NEXT_BUTTON_PX * number
    yield from ui.click(x, y)
    waited_s = 0.0
    while not started(ui, operator) and waited_s < ANSWER_S:
        yield 0.2
        waited_s += 0.2
    ui.results["clicked"][operator] = started(ui, operator)
    if not started(ui, operator):
        ui.operator(operator)


def started(ui, operator):
    """Whether its job runs, or ran."""
    return ui.job == operator or operator in reports()


def reports():
    """What the jobs told."""
    return bpy.context.window_manager.spectral_probe_reports


def shading(ui):
    """Of the 3D viewport."""
    return ui.area("VIEW_3D").spaces.active.shading


STEPS = (install, drop_photographs, photographs_to_light, add_metals, render_and_compare)
