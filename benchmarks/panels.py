"""How long each panel of the extension takes to draw, with a capture, a probe, a render and a comparison in the scene.

Usage, from the repository, on a machine that does nothing else (the scene is what sample_scenes/batch_render.py leaves):

    .venv/bin/python benchmarks/panels.py SCENE.blend [--draws 200]

Each panel's `draw` is called with a real layout as often as asked, in turn with all others. Prints one JSON object: milliseconds
by panel, median and 95th percentile, the slowest first; and the panels that this scene or its window does not show. Menus of
presets, which Blender draws, are left out. What Blender does with the finished layout (placing and painting the widgets, in
C++) is not in it.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
MODULE = "bl_ext.user_default.spectral_probe"
_UNCOUNTED = 5  # first draws fill caches


class Drawn:
    """What draw() is called on: the panel's class with a layout."""

    def __init__(self, panel: type, layout: Any) -> None:
        self.layout = layout
        self._panel = panel

    def __getattr__(self, name: str) -> Any:
        """All else is the class's."""
        return getattr(self._panel, name)


def enable(resources: Path) -> None:
    """Enable the checkout through Blender's own loader, in a user folder of its own."""
    repository = resources / "extensions" / "user_default"
    repository.mkdir(parents=True)
    (repository / "spectral_probe").symlink_to(ROOT, target_is_directory=True)
    os.environ["BLENDER_USER_RESOURCES"] = str(resources)
    import addon_utils

    if addon_utils.enable(MODULE) is None:
        sys.exit("The extension could not be enabled, for the reason above.")


def draw_s(panel: Any) -> float | None:
    """Seconds of one drawing of a panel; None where its poll() says no."""
    import bpy

    context = bpy.context
    window = context.window_manager.windows[0]
    area = next((area for area in window.screen.areas if area.type == panel.bl_space_type), None)
    if area is None:
        return None
    region = next((region for region in area.regions if region.type == panel.bl_region_type), None)
    place = {"window": window, "area": area} | ({} if region is None else {"region": region})
    material = next(iter(bpy.data.materials), None)
    light = next(iter(bpy.data.lights), None)
    with context.temp_override(**place, material=material, light=light):
        if hasattr(panel, "poll") and not panel.poll(context):
            return None
        layout = context.window_manager.popmenu_begin__internal("panel").layout.column()
        drawn = Drawn(panel, layout)
        start_s = time.perf_counter()
        if hasattr(panel, "draw_header"):
            panel.draw_header(drawn, context)
        panel.draw(drawn, context)
        return time.perf_counter() - start_s


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", type=Path, metavar="SCENE.blend")
    parser.add_argument("--draws", type=int, default=200)
    arguments = parser.parse_args()
    standard_output = os.dup(1)
    os.dup2(
        os.open(os.devnull, os.O_WRONLY), 1
    )  # without a window Blender has no icons, and says so for each
    with tempfile.TemporaryDirectory() as folder:
        os.environ["BLENDER_USER_RESOURCES"] = folder
        import bpy

        enable(Path(folder))
        bpy.ops.wm.open_mainfile(filepath=str(arguments.scene.resolve()))
        names = sorted(name for name in dir(bpy.types) if name.startswith("SPECTRAL_PROBE_PT_"))
        panels = {name: getattr(bpy.types, name) for name in names if not name.endswith("_presets")}
        times_s: dict[str, list[float]] = {name: [] for name in panels}
        for draw in range(arguments.draws + _UNCOUNTED):
            for name, panel in panels.items():
                seconds = draw_s(panel)
                if seconds is not None and draw >= _UNCOUNTED:
                    times_s[name].append(seconds)
    shown = {
        name.removeprefix("SPECTRAL_PROBE_PT_"): {
            "median_ms": round(1e3 * statistics.median(seconds), 3),
            "p95_ms": round(1e3 * statistics.quantiles(seconds, n=20)[-1], 3),
        }
        for name, seconds in times_s.items()
        if seconds
    }
    slowest_first = dict(sorted(shown.items(), key=lambda item: -item[1]["median_ms"]))
    os.dup2(standard_output, 1)
    hidden = [name for name, seconds in times_s.items() if not seconds]
    print(json.dumps({"panels": slowest_first, "not_shown": hidden}, indent=1))  # noqa: T201


if __name__ == "__main__":
    main()
