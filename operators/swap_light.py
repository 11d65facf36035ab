"""Exchange a light of the finished render."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy

from ..spectral_probe.model import Job
from .job import JobOperator
from .pictures import show_render
from .polls import has_render_files
from .settings import folder_of


def keep_lights(settings: bpy.types.PropertyGroup, directory: Path) -> None:
    """Keep which lights of a render can be exchanged and what each is now; none where nothing can."""
    from ..spectral_probe.model import finish
    from ..spectral_probe.swapping import list_lights

    lights = finish(list_lights(directory))["lights"]
    settings.swap.lights = "\n".join(f"{name}\t{now}" for name, now in lights.items())
    if lights and settings.swap.light not in lights:
        settings.swap.light = next(iter(lights))


class SPECTRAL_PROBE_OT_swap_light(JobOperator, bpy.types.Operator):
    """Put another lamp or stained glass into the finished render, without rendering again"""

    bl_idname = "spectral_probe.swap_light"
    bl_label = "Swap Light"

    in_thread = True
    needs = ("..spectral_probe.swapping", ".bridge.images")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """The render must have stored its layers."""
        return has_render_files(
            cls,
            context,
            "swappable.exr",
            "Make a region or lamps swappable, and render the scene first",
        )

    def job(self, context: bpy.types.Context) -> Job[dict[str, Any]]:
        """Read the settings and start."""
        from ..spectral_probe.swapping import swap_light

        settings = context.scene.spectral_probe
        swap = settings.swap
        lamp = bpy.path.abspath(swap.lamp_path) or swap.lamp
        glass = bpy.path.abspath(swap.glass_path) or swap.glass
        return swap_light(
            folder_of(settings.render_directory, "render"),
            swap.light,
            lamp=lamp if swap.kind == "LAMP" else None,
            glass=glass if swap.kind == "GLASS" else None,
            keeps=swap.keeps,
        )

    def done(self, context: bpy.types.Context, result: dict[str, Any]) -> None:
        """Show the new image."""
        from .render_spectral import write_preview

        settings = context.scene.spectral_probe
        directory = Path(result["written"])
        keep_lights(settings, directory)
        write_preview(directory / "xyz.exr")
        show_render(directory / "image.exr")
        self.tell("INFO", f"{settings.swap.light}: {result['lights'].get(settings.swap.light, '')}")
