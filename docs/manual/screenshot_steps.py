"""Runs in Blender, started by screenshots.py: goes through the manual's example and takes its pictures.

Of the properties editor only the panels that a picture is about are shown; Blender's own are left out of it.
"""

from __future__ import annotations

import importlib.util
import math
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy

_ROOT = Path(__file__).resolve().parents[2]
_DRIVER = _ROOT / "tests" / "window" / "driver.py"
_LIMIT_S = 1500.0
_RENDER_PX = (480, 320)
_RENDER_SAMPLES = 32
_PROBE_PX = 512
_WINDOW_DEG = (4.0, 21.0)
"""Bearing and elevation of a window of the gym."""
_CORNERS = "354 9, 16 9, 16 32, 354 32"
_OBJECTS = {
    "GOLD_PEDESTAL": (-0.10, 0.05, 0.0),
    "SILVER_BALL": (-0.10, 0.05, 0.5),
    "COPPER_BALL": (0.27, -0.16, 0.0),
}
_PREFIX = "SPECTRAL_PROBE_PT_"


def steps(ui: Any) -> Iterator[float]:
    """Every picture in the order of the work."""
    photographs = Path(ui.words[0])
    panels = OwnPanels()
    try:
        for part in (arranging, importing, capturing, building, lighting, pointing, painting, rendering):
            with ui.step(part.__name__):
                yield from part(ui, panels, photographs)
    finally:
        panels.restore()


class OwnPanels:
    """The extension's panels in the properties editor; only those asked for are drawn, and all of them open."""

    def __init__(self) -> None:
        """Take away Blender's panels of the same tabs, and have ours open."""
        self._all, self._blenders = [], []
        for name in dir(bpy.types):
            panel = getattr(bpy.types, name)
            if getattr(panel, "bl_space_type", "") != "PROPERTIES" or not isinstance(panel, type):
                continue
            if name.startswith(_PREFIX):
                if not name.endswith("_presets"):
                    self._all.append(panel)
            elif getattr(panel, "bl_context", "") in {"world", "render", "material", "data"}:
                self._blenders.append(panel)
        self._blenders.sort(key=_depth)
        for panel in reversed(self._blenders):
            bpy.utils.unregister_class(panel)
        registered = (_ROOT / "panels" / "__init__.py").read_text("utf-8")
        self._all.sort(
            key=lambda panel: registered.rindex(f"{panel.__name__},")
        )  # parents first, in the pipeline's order
        for panel in reversed(self._all):
            bpy.utils.unregister_class(panel)
        for panel in self._all:
            panel.bl_options = set(getattr(panel, "bl_options", ())) - {"DEFAULT_CLOSED"}
            bpy.utils.register_class(panel)

    def only(self, *names: str) -> None:
        """Draw these, their parents among them."""
        for panel in reversed(self._all):
            if panel.is_registered:
                bpy.utils.unregister_class(panel)
        for panel in self._all:
            if panel.__name__.removeprefix(_PREFIX) in names:
                bpy.utils.register_class(panel)

    def restore(self) -> None:
        """Have all panels again: their owners take them away when Blender quits."""
        self.only(*(panel.__name__.removeprefix(_PREFIX) for panel in self._all))
        for panel in self._blenders:
            bpy.utils.register_class(panel)


def _depth(panel: Any) -> int:
    parent = getattr(panel, "bl_parent_id", "")
    return 1 + _depth(getattr(bpy.types, parent)) if parent else 0


def settings(ui: Any) -> Any:
    """The scene's settings; undo makes new ones."""
    return ui.scene.spectral_probe


def arranging(ui: Any, _panels: OwnPanels, _photographs: Path) -> Iterator[float]:
    """A large editor on the left, the properties on the right, the file browser in the window itself."""
    view = bpy.context.preferences.view
    view.filebrowser_display_type, view.show_developer_ui, view.show_statusbar_version = (
        "SCREEN",
        False,
        False,
    )
    view.render_display_type = "NONE"
    for kind in ("DOPESHEET_EDITOR", "OUTLINER", "PROPERTIES"):
        with bpy.context.temp_override(window=ui.window, area=ui.area(kind)):
            bpy.ops.screen.area_close()
        yield 0.3
    with ui.context("VIEW_3D"):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.66)
    yield 0.3
    max(ui.window.screen.areas, key=lambda area: area.x).ui_type = "PROPERTIES"
    yield 0.3
    yield from ui.properties("WORLD")
    yield from ui.sidebar("VIEW_3D")
    yield from resting(ui)


def resting(ui: Any) -> Iterator[float]:
    """Move the mouse, and the pointer that is seen, out of the picture."""
    ui.window.cursor_warp(ui.window.width - 4, 4)
    yield from ui.move(ui.window.width - 4, 4)
    yield 0.5


def importing(ui: Any, panels: OwnPanels, photographs: Path) -> Iterator[float]:
    """The file browser of File > Import, then the photographs dropped on the viewport."""
    panels.only("light_probe", "capture")
    ui.operator("wm.save_as_mainfile", "EXEC_DEFAULT", at=None, filepath=str(photographs / "gym.blend"))
    ui.operator("spectral_probe.import_photographs", directory=str(photographs) + "/")
    yield 1.5
    browser = ui.area("FILE_BROWSER")
    browser.spaces.active.params.display_type = "LIST_VERTICAL"
    yield from ui.key("A", "FILE_BROWSER")
    yield 0.5
    ui.shot("import")
    yield from ui.key("ESC", "FILE_BROWSER")
    yield from ui.wait(
        lambda: "VIEW_3D" in {area.type for area in ui.window.screen.areas}, 20, "the viewport"
    )
    yield 0.5
    ui.drop(sorted(photographs.glob("*.dng")), "VIEW_3D")
    yield from ui.wait_job()
    yield from resting(ui)
    ui.shot("imported")


def capturing(ui: Any, panels: OwnPanels, _photographs: Path) -> Iterator[float]:
    """Camera, lamps, ball; the outline over a photograph."""
    for name, shown in (("capture", "photographs"), ("camera", "camera"), ("lamps", "lamps")):
        panels.only("light_probe", "capture", shown)
        yield 0.3
        ui.shot(name, "PROPERTIES")
    panels.only("light_probe", "ball")
    yield from ui.show("IMAGE_EDITOR", "VIEW_3D")
    settings(ui).overlay.exposure_ev = 0.0
    ui.operator("spectral_probe.detect_ball", at="IMAGE_EDITOR")
    yield from ui.wait_job()
    ui.shot("ball", "PROPERTIES")
    ui.operator("spectral_probe.show_photograph", at="IMAGE_EDITOR")
    yield from ui.wait_job()
    yield from ui.sidebar("IMAGE_EDITOR")
    with ui.context("IMAGE_EDITOR"):
        bpy.ops.image.view_zoom_ratio(ratio=1.5)
        bpy.ops.image.view_pan(offset=(70.0, 0.0))
    yield 0.3
    yield from resting(ui)
    ui.shot("outline", "IMAGE_EDITOR")


def building(ui: Any, panels: OwnPanels, _photographs: Path) -> Iterator[float]:
    """The probe, and a plot of one direction."""
    panels.only("light_probe", "probe")
    settings(ui).probe_width = _PROBE_PX
    ui.operator("spectral_probe.build_probe", at="IMAGE_EDITOR")
    yield from ui.wait_job()
    chosen = settings(ui).spectrum
    chosen.azimuth, chosen.elevation = map(math.radians, _WINDOW_DEG)
    ui.shot("probe", "PROPERTIES")
    ui.operator("spectral_probe.show_spectrum", at="IMAGE_EDITOR")
    yield from ui.wait_job()
    with ui.context("IMAGE_EDITOR"):
        bpy.ops.image.view_all(fit_view=True)
    ui.area("IMAGE_EDITOR").spaces.active.show_region_ui = False
    yield 0.3
    ui.shot("spectrum", "IMAGE_EDITOR")
    panels.only("light_probe", "probe", "plots")
    yield 0.3
    ui.shot("plots", "PROPERTIES")


def lighting(ui: Any, panels: OwnPanels, _photographs: Path) -> Iterator[float]:
    """Gold, silver and copper in the light, in the viewport's rendered mode."""
    yield from ui.show("VIEW_3D", "IMAGE_EDITOR")
    panels.only("light_probe", "world", "files")
    ui.scene.render.engine = "CYCLES"
    ui.scene.cycles.preview_samples = 24
    ui.operator("object.select_all", action="SELECT")
    ui.scene.camera.select_set(False)
    ui.operator("object.delete", "EXEC_DEFAULT")
    ui.operator("spectral_probe.light_world")
    for kind, location_m in _OBJECTS.items():
        ui.scene.cursor.location = location_m
        ui.operator("spectral_probe.add_object", "EXEC_DEFAULT", kind=kind)
    camera = ui.scene.camera
    camera.location, camera.rotation_euler = (0.05, -1.9, 0.55), (1.43, 0.0, 0.0)
    ui.scene.render.resolution_x, ui.scene.render.resolution_y = _RENDER_PX
    space = ui.area("VIEW_3D").spaces.active
    space.region_3d.view_perspective = "CAMERA"
    space.overlay.show_overlays = False
    space.show_gizmo = False
    with ui.context("VIEW_3D"):
        bpy.ops.view3d.view_center_camera()
    space.shading.type = "RENDERED"
    yield from resting(ui)
    yield 25.0
    ui.shot("lit", "VIEW_3D")
    ui.shot("world", "PROPERTIES")
    space.shading.type = "SOLID"
    space.overlay.show_overlays = True
    ui.shot("guide", "VIEW_3D", "UI")


def pointing(ui: Any, _panels: OwnPanels, _photographs: Path) -> Iterator[float]:
    """A direction's spectrum beside the mouse, then a region and the glasses for it."""
    yield from ui.show("IMAGE_EDITOR", "VIEW_3D")
    ui.operator("spectral_probe.show_panorama", at="IMAGE_EDITOR")
    yield from ui.wait_job()
    yield 0.5
    with ui.context("IMAGE_EDITOR"):
        bpy.ops.image.view_all(fit_view=True)
    yield 0.3
    ui.operator("spectral_probe.pick_direction", at="IMAGE_EDITOR")
    shown = bpy.context.window_manager.spectral_probe_panorama
    yield from ui.move(*_place(ui, *_WINDOW_DEG))
    yield from ui.wait(lambda: shown.has_spectrum and not shown.problem, 90, "the spectrum")
    yield from ui.move(*_place(ui, *_WINDOW_DEG))
    ui.shot("direction", "IMAGE_EDITOR")
    yield from ui.click(*_place(ui, *_WINDOW_DEG))
    ui.operator("spectral_probe.draw_region", "EXEC_DEFAULT", at="IMAGE_EDITOR", corners=_CORNERS)
    yield 0.3
    ui.operator("spectral_probe.edit_region", at="IMAGE_EDITOR")
    ui.shot("region", "IMAGE_EDITOR")
    yield from ui.key("ESC", "IMAGE_EDITOR")
    ui.operator("spectral_probe.choose_glass", at="IMAGE_EDITOR")
    yield 0.5
    ui.shot("glasses", "IMAGE_EDITOR")
    yield from ui.key("ESC", "IMAGE_EDITOR")
    ball = [getattr(bpy.types, _PREFIX + name) for name in ("image_ball", "image_overlay")]
    for panel in reversed(ball):
        bpy.utils.unregister_class(panel)
    yield from ui.sidebar("IMAGE_EDITOR")
    ui.shot("panorama", "IMAGE_EDITOR", "UI")
    for panel in ball:
        bpy.utils.register_class(panel)


def _place(ui: Any, azimuth_deg: float, elevation_deg: float) -> tuple[int, int]:
    """Where a direction is in the window."""
    package = "bl_ext.user_default.spectral_probe."
    arcs = importlib.import_module(package + "spectral_probe.geometry.arcs")
    picture = importlib.import_module(package + "operators.bridge.panorama_image")
    region = ui.region("IMAGE_EDITOR")
    view = picture.view_in(region, ui.area("IMAGE_EDITOR").spaces.active.image)
    x, y = view.placed(arcs.bearing_to_picture(azimuth_deg, elevation_deg))
    return int(region.x + x), int(region.y + y)


def painting(ui: Any, panels: OwnPanels, _photographs: Path) -> Iterator[float]:
    """The library in the properties of a material."""
    yield from ui.show("VIEW_3D", "IMAGE_EDITOR")
    panels.only("material", "material_swatches")
    ui.scene.view_layers[0].objects.active = ui.scene.objects[-1]
    yield from ui.properties("MATERIAL")
    ui.operator("spectral_probe.show_swatches", at="PROPERTIES")
    yield from ui.wait_job()
    ui.shot("material", "PROPERTIES")


def rendering(ui: Any, panels: OwnPanels, _photographs: Path) -> Iterator[float]:
    """Plan, render, compare; an Image Editor is there to show the sheet, or Blender opens a further window."""
    panels.only("render")
    yield from ui.properties("RENDER")
    settings(ui).samples = _RENDER_SAMPLES
    ui.operator("spectral_probe.plan_render")
    yield from ui.wait_job()
    ui.shot("plan", "PROPERTIES")
    yield from ui.show("IMAGE_EDITOR", "VIEW_3D")
    ui.operator("spectral_probe.render_and_compare", at="PROPERTIES")
    yield from ui.wait_job(600.0)
    ui.area("IMAGE_EDITOR").spaces.active.show_region_ui = False
    panels.only("render", "compare")
    yield 1.0
    with ui.context("IMAGE_EDITOR"):
        bpy.ops.image.view_all(fit_view=True)
    yield 0.5
    ui.shot("sheet", "IMAGE_EDITOR")
    ui.shot("compare", "PROPERTIES")


def _main() -> None:
    specification = importlib.util.spec_from_file_location("driver", _DRIVER)
    driver = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(driver)
    driver._LIMIT_S = _LIMIT_S
    output, *words = sys.argv[sys.argv.index("--") + 1 :]
    driver.start(Path(__file__).resolve(), Path(output), words)


if __name__ == "__main__":
    _main()
