"""What the driver does: keys, clicks, drags, typing, drops, reports, freezes."""

import time

import bpy


def steps(ui):
    """Use every part of the driver once."""
    ui.operator("object.select_all", action="DESELECT")
    yield from ui.key("A")
    ui.results["selected by a key"] = len([o for o in ui.scene.objects if o.select_get()])
    ui.operator("object.select_all", action="DESELECT")
    ui.scene.objects["Cube"].select_set(True)
    ui.window.view_layer.objects.active = ui.scene.objects["Cube"]
    yield from ui.key("F3")
    yield from ui.type_text("shade auto smooth")
    yield 0.3
    ui.shot("search")
    yield from ui.key("RET")
    yield 0.3
    ui.results["modifiers found by search"] = len(ui.scene.objects["Cube"].modifiers)
    ui.results["polls"] = ui.polls("spectral_probe.use_cycles")
    ui.operator("spectral_probe.use_cycles")
    ui.results["polls again"] = ui.polls("spectral_probe.use_cycles")
    ui.results["error"] = ui.error_of("spectral_probe.import_capture", "EXEC_DEFAULT", filepath="/none.toml")
    ui.drop([ui.words[0]], "VIEW_3D")
    yield from ui.wait_job()
    ui.results["views dropped"] = len(ui.scene.spectral_probe.views)
    with ui.step("frozen"):
        yield 0.1
        time.sleep(0.4)
        yield 0.1
    with ui.step("alive"):
        yield 0.3
    yield from ui.sidebar("VIEW_3D")
    ui.shot("sidebar", "VIEW_3D", "UI")
    yield from ui.show("IMAGE_EDITOR", "DOPESHEET_EDITOR")
    yield from ui.properties("WORLD")
    region = ui.region("VIEW_3D")
    x, y = region.x + region.width // 2, region.y + region.height // 2
    with ui.context("VIEW_3D"):
        before = tuple(bpy.context.region_data.view_rotation)
        yield from ui.drag([(x, y), (x + 40, y), (x + 80, y + 10)], "MIDDLEMOUSE")
        yield 0.2
    with ui.context("VIEW_3D"):
        ui.results["turned by a drag"] = tuple(bpy.context.region_data.view_rotation) != before
    ui.shot("screen")
