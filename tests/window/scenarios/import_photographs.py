"""Photographs come in by every way that a window has: dropped on editors, chosen in a file browser, from the menu."""

from pathlib import Path

import bpy


def steps(ui):
    """Drop, choose, move, undo; words: a folder with the gym's photographs and no capture file, and a JPEG."""
    gym, jpeg = Path(ui.words[0]), Path(ui.words[1])
    raw = sorted(gym.glob("*.dng"))
    ui.open_panels("SPECTRAL_PROBE_PT_photographs")
    yield from ui.show("IMAGE_EDITOR", "DOPESHEET_EDITOR")
    yield from ui.properties("WORLD")

    def views():
        return [len(view.photos) for view in ui.scene.spectral_probe.views]

    def idle():
        return not bpy.context.window_manager.spectral_probe.operator

    for place in ("VIEW_3D", "IMAGE_EDITOR", "PROPERTIES"):
        with ui.step(f"drop on {place}"):
            ui.drop(raw, place)
            yield from ui.wait(lambda: views() and idle(), 20, f"the views dropped on {place}")
        ui.results[place] = views()
        if place == "PROPERTIES":
            ui.shot("dropped")
            break
        ui.operator("ed.undo", at="VIEW_3D")
        yield 0.3
        ui.results[f"{place} undone"] = views()

    ui.drop([jpeg], "IMAGE_EDITOR")  # Blender opens pictures there too: it asks
    yield 0.5
    ui.shot("asked")
    yield from ui.key("ESC")
    yield 0.3
    ui.results["not chosen"] = views()

    yield from ui.properties("WORLD")
    ui.shot("properties", "PROPERTIES")
    ui.operator("spectral_probe.move_photo", at="PROPERTIES", view=2)
    yield 0.2
    ui.results["moved"] = views()
    ui.operator("ed.undo", at="VIEW_3D")
    yield 0.3
    ui.results["moved back"] = views()

    ui.scene.spectral_probe.views.clear()
    ui.operator("spectral_probe.import_photographs")
    browser = yield from ui.file_browser(gym)
    with bpy.context.temp_override(**browser):
        bpy.ops.file.select_all(action="SELECT")
    ui.redraw()
    ui.shot("browser")
    with bpy.context.temp_override(**browser):
        bpy.ops.file.execute()
    yield from ui.wait(lambda: views() and idle(), 20, "the views chosen in the file browser")
    ui.results["chosen"] = views()
    yield from ui.properties("WORLD")
    x, y = ui.window.width // 2, ui.window.height // 2
    for kind, call in (("panel", "SPECTRAL_PROBE_PT_capture_presets"), ("menu", "SPECTRAL_PROBE_MT_photos")):
        yield from ui.move(x, y)
        with ui.context("VIEW_3D"):
            getattr(bpy.ops.wm, f"call_{kind}")(name=call)
        yield 0.5
        ui.shot(kind)
        yield from ui.key("ESC")
        yield 0.3
    ui.operator("spectral_probe.load_preset", at="PROPERTIES", filepath=ui.words[2], kind="capture")
    ui.results["camera"] = ui.scene.spectral_probe.camera.model
