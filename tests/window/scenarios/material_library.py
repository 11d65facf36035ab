"""The library with swatches in the material's properties, and an asset dragged out of the browser onto an object."""

import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d


def steps(ui):
    """Choose a metal from the list, then drag a glass onto the cube."""
    yield from choosing(ui)
    yield from dragging(ui)


def choosing(ui):
    material, listed = (
        ui.scene.objects["Cube"].active_material,
        bpy.context.window_manager.spectral_probe_swatches,
    )
    material.spectral_probe.kind = "METAL"
    for name in [name for name in dir(bpy.types) if name.startswith(("MATERIAL_PT_", "EEVEE_MATERIAL_PT_"))]:
        panel = getattr(bpy.types, name)
        if name != "EEVEE_MATERIAL_PT_context_material" and hasattr(panel, "bl_context"):
            bpy.utils.unregister_class(panel)  # ours are below them, outside of the picture
    ui.open_panels()
    yield from ui.show("PROPERTIES", "VIEW_3D")
    yield from ui.properties("MATERIAL")
    ui.shot("before", "PROPERTIES")
    with ui.step("swatches"):
        ui.operator("spectral_probe.show_swatches", at="PROPERTIES")
        yield from ui.wait_job()
    ui.shot("metals", "PROPERTIES")
    listed.search = "gold"
    yield 0.2
    ui.shot("search", "PROPERTIES")
    ui.results["found"] = [item.entry for item in listed.items if item.kind == "METAL"]
    listed.search = ""
    material.spectral_probe.chosen_surface = listed.items.find("METAL|Cu")
    yield 0.2
    ui.shot("chosen", "PROPERTIES")
    ui.results["chosen"] = material.spectral_probe.metal
    yield from ui.show("VIEW_3D", "PROPERTIES")


def dragging(ui):
    ui.operator("spectral_probe.add_asset_library")
    with ui.context("VIEW_3D"):
        bpy.ops.screen.area_split(direction="HORIZONTAL", factor=0.5)
    yield 0.3
    lower = min((a for a in ui.window.screen.areas if a.type == "VIEW_3D"), key=lambda area: area.y)
    lower.ui_type = "ASSETS"
    yield 0.3
    lower.spaces.active.params.asset_library_reference = "Spectral Probe"
    yield 3.0  # it reads the library
    view = ui.region("VIEW_3D")
    space = ui.area("VIEW_3D").spaces.active.region_3d
    cube = location_3d_to_region_2d(view, space, ui.scene.objects["Cube"].location)
    browser = next(region for region in lower.regions if region.type == "WINDOW")
    start = (browser.x + 60, browser.y + browser.height - 50)
    end = (view.x + int(cube.x), view.y + int(cube.y))
    way = [
        (start[0] + (end[0] - start[0]) * n // 8, start[1] + (end[1] - start[1]) * n // 8) for n in range(9)
    ]
    yield from ui.drag(way)
    yield 0.5
    ui.shot("dragged")
    dropped = ui.scene.objects["Cube"].active_material
    ui.results["dropped"] = [dropped.name, dropped.spectral_probe.kind, dropped.is_editable]
    ui.operator("spectral_probe.remove_asset_library")
    ui.results["left"] = [
        e.name for e in bpy.context.preferences.filepaths.asset_libraries if "Probe" in e.name
    ]
