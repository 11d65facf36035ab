"""Operators found by Blender's search, and, where this Blender has languages, the window in German."""

import bpy

GERMAN = "de_DE"


def steps(ui):
    """Search twice, then change the language."""
    yield from searching(ui)
    view = bpy.context.preferences.view
    languages = [item.identifier for item in view.bl_rna.properties["language"].enum_items]
    ui.results["german"] = GERMAN in languages
    if ui.results["german"]:
        yield from in_german(ui, view)


def searching(ui):
    ui.scene.render.engine = "BLENDER_EEVEE"
    yield from ui.key("F3")
    yield from ui.type_text("switch to cycles")
    yield 0.5
    ui.shot("search")
    yield from ui.key("RET")
    yield 0.3
    ui.results["engine"] = ui.scene.render.engine
    yield from ui.show("IMAGE_EDITOR", "VIEW_3D")
    yield from ui.key("F3", "IMAGE_EDITOR")
    yield from ui.type_text("region with lamps", "IMAGE_EDITOR")
    yield 0.5
    ui.shot("search_image")
    yield from ui.key("RET", "IMAGE_EDITOR")
    yield 0.3
    ui.results["regions"] = len(ui.scene.spectral_probe.known_light.regions)
    yield from ui.show("VIEW_3D", "IMAGE_EDITOR")


def in_german(ui, view):
    view.language = GERMAN
    for name in ("interface", "tooltips", "reports"):
        setattr(view, f"use_translate_{name}", True)
    if ui.words:
        ui.operator("spectral_probe.import_photographs", filepath=ui.words[0])
        yield from ui.wait_job()
    yield from ui.sidebar("VIEW_3D")
    yield from ui.properties("WORLD")
    ui.shot("german")
    yield from ui.key("F3")
    yield from ui.type_text("spektral")
    yield 0.5
    ui.shot("german_search")
    yield from ui.key("ESC")
    ui.results["error"] = ui.error_of("spectral_probe.import_photographs", "EXEC_DEFAULT")
    view.language = "en_US"
    yield 0.2
