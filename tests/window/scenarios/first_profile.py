"""From a Blender that was never started to the comparison of a spectral and an RGB render, as an artist goes."""

import bpy

MODULE = "bl_ext.user_default.spectral_probe"
SIZE_PX = (96, 64)
OBJECTS = {
    "GOLD_PEDESTAL": (-0.10, 0.05, 0.0),
    "SILVER_BALL": (-0.10, 0.05, 0.5),
    "COPPER_BALL": (0.27, -0.16, 0.0),
}


def steps(ui):
    """Each step timed, with a picture of the screen after it."""
    for number, step in enumerate(STEPS):
        with ui.step(step.__name__):
            yield from step(ui)
        yield 0.3
        ui.shot(f"{number}_{step.__name__}")


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


def import_photographs(ui):
    """The capture is dropped on the 3D viewport."""
    ui.drop([ui.words[1]], "VIEW_3D")
    yield from ui.wait_job()
    ui.results["views"] = [len(view.photos) for view in ui.scene.spectral_probe.views]


def detect(ui):
    """The ball in every view."""
    ui.operator("spectral_probe.detect_ball")
    yield from ui.wait_job()
    ui.results["outline_rms_px"] = [round(view.found_rms_px, 3) for view in ui.scene.spectral_probe.views]


def build(ui):
    """The probe, coarse: what is tested is that it is built at all."""
    ui.scene.spectral_probe.probe_width = 256
    ui.operator("spectral_probe.build_probe")
    yield from ui.wait_job()
    ui.results["blind_fraction"] = ui.scene.spectral_probe.probe.blind_fraction


def light(ui):
    """The world, seen in the viewport."""
    ui.scene.render.engine = "CYCLES"
    ui.operator("spectral_probe.light_world")
    yield 0.2
    ui.results["world"] = ui.scene.world.name


def add_objects(ui):
    """Gold, silver and copper instead of the cube, seen by the camera."""
    ui.operator("object.select_all", action="SELECT")
    ui.scene.camera.select_set(False)
    ui.operator("object.delete", "EXEC_DEFAULT")
    for kind, location_m in OBJECTS.items():
        ui.scene.cursor.location = location_m
        ui.operator("spectral_probe.add_object", "EXEC_DEFAULT", kind=kind)
    ui.scene.camera.location, ui.scene.camera.rotation_euler = (0.05, -1.9, 0.55), (1.43, 0.0, 0.0)
    yield 0.2
    ui.results["objects"] = sorted(thing.name for thing in ui.scene.objects)


def render(ui):
    """A small spectral render, and its RGB twin."""
    ui.scene.render.resolution_x, ui.scene.render.resolution_y = SIZE_PX
    ui.scene.spectral_probe.samples = 4
    ui.operator("spectral_probe.render_spectral")
    yield from ui.wait_job()
    ui.results["passes"] = ui.scene.spectral_probe.render.passes


def compare(ui):
    """The sheet of the comparison."""
    ui.operator("spectral_probe.compare")
    yield from ui.wait_job()
    ui.results["mean_de2000"] = ui.scene.spectral_probe.comparison.mean_de2000


STEPS = (install, import_photographs, detect, build, light, add_objects, render, compare)
