"""The ball's outline over its photograph: drawn where it is at every zoom, dragged with a live fit, undone, saved."""

import importlib
from pathlib import Path

import bpy
import numpy as np

EXTENSION = "bl_ext.user_default.spectral_probe"
EDITOR = "IMAGE_EDITOR"


def module(name):
    return importlib.import_module(f"{EXTENSION}.{name}")


def steps(ui):
    """Check the mapping on a chart, then the outline on a photograph."""
    capture, folder = Path(ui.words[0]), ui.folder
    yield from ui.show(EDITOR, "VIEW_3D")
    yield from mapping(ui, folder)
    yield from overlay(ui, capture, folder)


def settings(ui):
    return ui.scene.spectral_probe


def zoom(ui, ratio, pan=(0.0, 0.0)):
    with ui.context(EDITOR):
        bpy.ops.image.view_all(fit_view=False)
        bpy.ops.image.view_zoom_ratio(ratio=ratio)
        bpy.ops.image.view_pan(offset=pan)
    yield 0.1


def mapping(ui, folder):
    """How far white squares of a chart lie on the screen from where the overlay would draw them, in pixels."""
    from PIL import Image

    squares = ((60, 40), (250, 130), (330, 60))
    chart = np.zeros((200, 400, 3), np.uint8)
    for x, y in squares:
        chart[y : y + 10, x : x + 10] = 255
    Image.fromarray(chart).save(folder / "chart.png")
    ui.operator(
        "spectral_probe.add_view",
        "EXEC_DEFAULT",
        at=EDITOR,
        directory=str(folder),
        files=[{"name": "chart.png"}],
    )
    view = settings(ui).views[0]
    ui.operator("spectral_probe.show_photograph", at=EDITOR)
    yield from ui.wait_job()
    settings(ui).overlay.show = False
    system = bpy.context.preferences.view
    places, sizes, round_trip = [], [], 0.0
    for scale, ratio, pan in ((1, 1.0, (0, 0)), (1, 2.5, (40, 30)), (1, 9.0, (150, 40)), (2, 1.5, (-60, 20))):
        system.ui_scale = scale
        yield 0.3
        yield from zoom(ui, ratio, pan)
        region = ui.region(EDITOR)
        space = module("operators.bridge.image_space").ImageSpace.of(region, view.shown.size_px)
        for place in ((0.0, 0.0), (123.4, 77.7)):
            back = space.to_photograph(*space.to_region(*place))
            round_trip = max(round_trip, float(np.hypot(*np.subtract(back, place))))
        area = ui.area(EDITOR)
        with Image.open(ui.shot(f"chart_{scale}_{ratio}", EDITOR)) as image:
            shown = np.asarray(image.convert("RGB"), float).min(axis=-1) / 255.0
        for x, y in squares:
            left, top = space.to_region(x, y)
            right, bottom = space.to_region(x + 10, y + 10)
            margin = 3
            inside = left > 60 and bottom > 60 and right < region.width - 60 and top < region.height - 120
            if not inside:
                continue
            # The area's picture begins at its top; the region's pixels at its bottom.
            row0 = area.y + area.height - region.y
            rows = slice(int(row0 - top) - margin, int(row0 - bottom) + margin + 1)
            columns = slice(
                int(left + region.x - area.x) - margin, int(right + region.x - area.x) + margin + 1
            )
            part = shown[rows, columns]
            mass = part.sum()
            centre_x = (part.sum(axis=0) @ (np.arange(columns.start, columns.stop) + 0.5)) / mass
            centre_y = row0 - (part.sum(axis=1) @ (np.arange(rows.start, rows.stop) + 0.5)) / mass
            places.append(abs(centre_x - (region.x - area.x) - (left + right) / 2))
            places.append(abs(centre_y - (top + bottom) / 2))
            sizes.append(abs(np.sqrt(mass) - (right - left)))
    system.ui_scale = 1
    ui.results["squares measured"] = len(sizes)
    ui.results["worst place px"] = round(float(max(places)), 3)
    ui.results["worst size px"] = round(float(max(sizes)), 3)
    ui.results["round trip px"] = round_trip
    settings(ui).overlay.show = True
    settings(ui).views.clear()
    yield 0.2


def on_screen(ui, place_px):
    """Where a place of the first photograph is in the window."""
    region, view = ui.region(EDITOR), settings(ui).views[0]
    x, y = module("operators.edit_outline").space_of(region, view).to_region(*place_px)
    return region.x + x, region.y + y


def numbers(ui):
    view = settings(ui).views[0]
    circle = [*view.found_centre_px, sum(view.found_semi_axes_px) / 2]
    return [round(value, 2) for value in circle], [round(value, 2) for value in view.outline_px]


def overlay(ui, capture, folder):
    ui.operator("spectral_probe.import_capture", "EXEC_DEFAULT", at=EDITOR, filepath=str(capture))
    view, state = settings(ui).views[0], settings(ui)
    view.outline_source, view.outline_px, state.all_views = "SNAP", (240.0, 240.0, 200.0), False
    with ui.step("fit near a circle"):
        ui.operator("spectral_probe.detect_ball", at=EDITOR)
        yield from ui.wait_job()
    ui.results["found"] = numbers(ui)
    ui.results["summary"] = len(view.shown.summary) > 1000
    yield from zoom(ui, 1.5)
    yield from ui.sidebar(EDITOR)
    ui.shot("found")
    ui.operator("ed.undo_push", "EXEC_DEFAULT", at=None, message="before the drag")

    before = numbers(ui)
    x, y = on_screen(ui, (view.outline_px[0] - view.outline_px[2], view.outline_px[1]))
    with ui.step("drag"):
        yield from ui.move(x, y)
        yield 0.2
        yield from ui.drag([(x, y), (x - 6, y), (x - 12, y + 2), (x - 20, y)])
        ui.results["dragged"] = numbers(ui)[1][2] > before[1][2] + 5
        running = {"SPECTRAL_PROBE_OT_edit_outline"}
        yield from ui.wait(
            lambda: not running & {one.bl_idname for one in ui.window.modal_operators}, 90, "the fit"
        )
    ui.shot("dragged")
    ui.results["after the drag"] = numbers(ui)
    ui.operator("ed.undo", "EXEC_DEFAULT", at=None)
    yield 0.2
    ui.results["undone"] = numbers(ui) == before
    ui.operator("ed.redo", "EXEC_DEFAULT", at=None)
    yield 0.2

    view, before = settings(ui).views[0], numbers(ui)
    x, y = on_screen(ui, view.outline_px[:2])
    yield from ui.move(x, y)
    yield 0.2
    place = {"x": int(x), "y": int(y)}
    ui.window.event_simulate(type="LEFTMOUSE", value="PRESS", **place)
    yield 0.1
    for step in range(1, 4):
        yield from ui.move(x + 10 * step, y + 5 * step, ctrl=True)
    ui.results["moved without snapping"] = settings(ui).views[0].outline_source == "GIVEN"
    ui.window.event_simulate(type="ESC", value="PRESS", **place)
    yield 0.1
    ui.window.event_simulate(type="ESC", value="RELEASE", **place)
    ui.window.event_simulate(type="LEFTMOUSE", value="RELEASE", **place)
    yield 0.3
    ui.results["restored"] = numbers(ui) == before and settings(ui).views[0].outline_source == "SNAP"

    bpy.context.preferences.view.ui_scale = 2
    yield 0.3
    yield from zoom(ui, 4.0, (-120, 60))
    ui.shot("zoomed_high_dpi")
    bpy.context.preferences.view.ui_scale = 1
    blend = str(folder / "scene.blend")
    ui.operator("wm.save_as_mainfile", "EXEC_DEFAULT", at=None, filepath=blend)
    saved = numbers(ui)
    ui.operator("wm.open_mainfile", "EXEC_DEFAULT", at=None, filepath=blend)
    yield 0.5
    view = settings(ui).views[0]
    ui.results["reopened"] = (
        numbers(ui) == saved
        and view.shown.picture.packed_file is not None
        and tuple(view.shown.size_px) == (480, 480)
    )
    ui.results["still shown"] = ui.area(EDITOR).spaces.active.image == view.shown.picture
    yield from zoom(ui, 1.5)
    ui.shot("reopened")
