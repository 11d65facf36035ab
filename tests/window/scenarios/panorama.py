"""The panorama tools: point, take a direction, draw a region and change it, glass and lamp, the viewport follows, undo."""

import importlib
import os
import time

import bpy

EXTENSION = "bl_ext.user_default.spectral_probe"


def steps(ui):
    """Everything an artist does over the panorama, by mouse and key; the word is the probe's folder."""
    ui.scene.spectral_probe.probe_directory = ui.words[0]
    ui.operator("spectral_probe.light_world")
    with ui.context("VIEW_3D"):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.4)
    yield 0.2
    max(ui.window.screen.areas, key=lambda area: area.width * area.height).ui_type = "IMAGE_EDITOR"
    yield 0.2
    yield from ui.sidebar("IMAGE_EDITOR")
    ui.results["picks without a picture"] = ui.polls("spectral_probe.pick_direction", "IMAGE_EDITOR")
    with ui.step("show"):
        ui.operator("spectral_probe.show_panorama", at="IMAGE_EDITOR")
        yield from ui.wait_job()
    yield 0.5
    ui.shot("shown")
    ui.area("IMAGE_EDITOR").spaces.active.show_region_ui = False  # it lies over the picture's right edge
    yield 0.3
    with ui.context("IMAGE_EDITOR"):
        bpy.ops.image.view_all(fit_view=True)
    yield 0.3
    yield from pointing(ui)
    yield from drawing(ui)
    yield from choosing(ui)
    yield from ending(ui)


def shown():
    """What the tools show now."""
    return bpy.context.window_manager.spectral_probe_panorama


def settings(ui):
    """The scene's; undo makes new ones."""
    return ui.scene.spectral_probe


def place(ui, azimuth_deg, elevation_deg):
    """Where a direction is in the window."""
    core = importlib.import_module(f"{EXTENSION}.spectral_probe.geometry.arcs")
    module = importlib.import_module(f"{EXTENSION}.operators.bridge.panorama_image")
    region = ui.region("IMAGE_EDITOR")
    view = module.view_in(region, ui.area("IMAGE_EDITOR").spaces.active.image)
    x, y = view.placed(core.bearing_to_picture(azimuth_deg, elevation_deg))
    return int(region.x + x), int(region.y + y)


def pointing(ui):
    """A direction by mouse; ESC; the seconds that one move takes."""
    ui.operator("spectral_probe.pick_direction", at="IMAGE_EDITOR")
    yield from ui.move(*place(ui, 4, 21))
    yield from ui.wait(lambda: shown().has_spectrum and not shown().problem, 90, "the probe")
    for azimuth in (30, 60, 4):
        yield from ui.move(*place(ui, azimuth, 21))
    ui.results["pointed at"] = [round(value, 1) for value in (shown().confidence, len(shown().points))]
    ui.shot("pointing")
    yield from moves(ui)
    before = settings(ui).spectrum.azimuth
    yield from ui.key("ESC", "IMAGE_EDITOR")
    ui.results["after ESC"] = [shown().has_spectrum, settings(ui).spectrum.azimuth == before]
    ui.operator("spectral_probe.pick_direction", at="IMAGE_EDITOR")
    yield 0.3
    yield from ui.click(*place(ui, 4, 21))
    taken = settings(ui).spectrum
    ui.results["taken"] = [
        round(57.29578 * taken.azimuth),
        round(57.29578 * taken.elevation),
        taken.has_numbers,
    ]


def moves(ui):
    """How long Blender takes for one move of the mouse, its drawing included: the median of some."""
    module = importlib.import_module(f"{EXTENSION}.operators.pick_direction")
    memory = importlib.import_module(f"{EXTENSION}.operators.bridge.opened_probe").MEMORY
    settings_module = importlib.import_module(f"{EXTENSION}.operators.settings")
    panorama = memory.read(settings_module.probe_folder(settings(ui)) / "probe.exr").panorama
    computed, drawn = [], []
    for azimuth in range(20, 29):
        start = time.perf_counter()
        module.show_direction(bpy.context, panorama, float(azimuth), 21.0)
        computed.append(time.perf_counter() - start)
        start = time.perf_counter()
        ui.redraw()
        drawn.append(time.perf_counter() - start)
    ui.results["ms of a move"] = round(1000 * sorted(computed)[4], 1)
    ui.results["ms of drawing the window"] = round(1000 * sorted(drawn)[4], 1)
    yield 0.1


def drawing(ui):
    """A polygon by clicks, Backspace, a double corner closes it; ESC; corners dragged, added, removed."""
    ui.operator("spectral_probe.draw_region", at="IMAGE_EDITOR")
    for corner in ((-6, 11), (15, 11), (60, -40)):
        yield from ui.click(*place(ui, *corner))
    yield from ui.key("BACK_SPACE", "IMAGE_EDITOR")
    for corner in ((15, 31), (-6, 31)):
        yield from ui.click(*place(ui, *corner))
    yield from ui.move(*place(ui, 40, 50))
    ui.shot("drawing")
    yield from ui.key("RET", "IMAGE_EDITOR")
    region = settings(ui).region
    first = region.polygon
    ui.results["drawn"] = [region.kind, len(first.split(","))]
    ui.operator("spectral_probe.draw_region", at="IMAGE_EDITOR")
    yield from ui.click(*place(ui, 200, -40))
    yield from ui.key("ESC", "IMAGE_EDITOR")
    ui.results["drawn after ESC"] = settings(ui).region.polygon == first
    ui.operator("spectral_probe.edit_region", at="IMAGE_EDITOR")
    yield from ui.drag([place(ui, 15, 31), place(ui, 18, 33), place(ui, 20, 35)])
    yield from ui.drag([place(ui, 4.5, 11), place(ui, 4.5, 8), place(ui, 4.5, 6)])
    ui.shot("editing")
    ui.results["corners after dragging"] = settings(ui).region.polygon
    yield from ui.click(*place(ui, 4.5, 6), ctrl=True)
    yield from ui.key("RET", "IMAGE_EDITOR")
    ui.results["corners after removing"] = len(settings(ui).region.polygon.split(","))
    yield 0.2
    with ui.context(None):
        bpy.ops.ed.undo()
    yield 0.3
    ui.results["undone"] = settings(ui).region.polygon == first
    with ui.context(None):
        bpy.ops.ed.redo()
    yield 0.3
    ui.operator("spectral_probe.draw_region", at="IMAGE_EDITOR", target="EDIT")
    around = [(255, -30), (285, -30), (285, 30), (255, 30)]
    for corner in around:
        yield from ui.click(*place(ui, *corner))
    ui.shot("over_the_seam")
    yield from ui.click(*place(ui, *around[0]))
    ui.results["closed on its first corner"] = [
        shown().polygon_of,
        len(settings(ui).region.polygon.split(",")),
    ]


def choosing(ui):
    """A glass from the searched list; the viewport follows; a lamp; undo."""
    ui.operator(
        "spectral_probe.draw_region", "EXEC_DEFAULT", at="IMAGE_EDITOR", corners="354 9, 16 9, 16 32, 354 32"
    )
    for area in ui.window.screen.areas:
        if area.type == "VIEW_3D":
            area.spaces.active.shading.type = "RENDERED"
            area.spaces.active.shading.use_scene_world_render = True
    ui.area("IMAGE_EDITOR").spaces.active.show_region_ui = True
    yield 2.0
    ui.operator("spectral_probe.choose_glass", at="IMAGE_EDITOR")
    yield 0.3
    yield from ui.type_text("copper", "IMAGE_EDITOR")
    yield 0.3
    ui.shot("choosing")
    image = world_image(ui)
    pixels = viewport(ui)
    start = time.perf_counter()
    with ui.step("glass"):
        yield from ui.key("RET", "IMAGE_EDITOR")
        yield from ui.wait(lambda: world_image(ui) != image, 60, "the world of the edited light")
        ui.results["s to the new world"] = round(time.perf_counter() - start, 2)
        while viewport(ui) == pixels and time.perf_counter() - start < 60:
            yield 0.02
        ui.results["s to the changed viewport"] = round(time.perf_counter() - start, 2)
        yield from ui.wait_job()
    yield 2.0
    ui.results["edits"] = [edit.name for edit in settings(ui).edits.items]
    ui.shot("glass")
    with ui.context(None):
        bpy.ops.ed.undo()
    yield 1.5
    ui.results["edits after undo"] = [edit.name for edit in settings(ui).edits.items]
    ui.shot("undone")
    with ui.context(None):
        bpy.ops.ed.redo()
    yield 1.0
    for kind in ("CONFIDENCE", "KINDS"):
        ui.operator("spectral_probe.show_panorama", at="IMAGE_EDITOR", picture=kind)
        yield from ui.wait_job()
        yield 0.5
        ui.shot(kind.lower())


def world_image(ui):
    """The file that lights the scene."""
    nodes = ui.scene.world.node_tree.nodes
    return next(node.image.filepath for node in nodes if node.type == "TEX_ENVIRONMENT")


def viewport(ui):
    """The pixels of the viewport on the screen."""
    if "XVFB_FBDIR" not in os.environ:
        return b""
    import struct
    from pathlib import Path

    data = (Path(os.environ["XVFB_FBDIR"]) / "Xvfb_screen0").read_bytes()
    head = struct.unpack(">25I", data[:100])
    offset, stride = head[0] + head[19] * 12, head[12]
    area = ui.area("VIEW_3D")
    row = ui.window.height - area.y - area.height // 4
    return data[offset + row * stride + area.x * 4 :][: area.width * 4]


def ending(ui):
    """Another image, another file while a tool runs: nothing stays behind."""
    ui.operator("spectral_probe.pick_direction", at="IMAGE_EDITOR")
    yield from ui.move(*place(ui, 100, 10))
    area = ui.area("IMAGE_EDITOR")
    area.spaces.active.image = None
    yield from ui.move(area.x + 200, area.y + 200)
    yield 0.2
    ui.results["following another image"] = shown().following
    ui.shot("no_image")
    area.spaces.active.image = bpy.data.images["Spectral Probe Panorama"]
    yield 0.3
    ui.operator("spectral_probe.draw_region", at="IMAGE_EDITOR")
    yield from ui.click(*place(ui, 100, 10))
    with ui.context(None):
        bpy.ops.wm.read_homefile(use_empty=False, use_factory_startup=True)
    yield 0.6
    ui.results["tools in a new file"] = [shown().polygon_of, shown().following]
