"""The words of the verb `composite`."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .cli_numbers import positive_number

if TYPE_CHECKING:
    from .model import Job

TEXT = "Put a spectral render into its photograph, with its shadows."
EXAMPLE = "composite render --plate photo.jpg -o composite"


def add_words(parser: argparse.ArgumentParser) -> None:
    """Give the verb its words, but for the folder to write to."""
    parser.add_argument("render", type=Path, metavar="RENDER_DIR", help="the folder of a spectral render")
    parser.add_argument(
        "--plate",
        type=Path,
        metavar="PHOTO|PROBE.exr",
        help="the photograph, of the render's size unless the scene has a backplate; or a probe as the background (default: the "
        "backplate's photograph)",
    )
    plate = parser.add_argument_group("what the backplate does not say, or says wrongly")
    plate.add_argument(
        "--response",
        metavar="srgb|FILE",
        help="how codes of a converted picture (JPEG) follow the light: the sRGB curve, or one measured, in a backplate.json or "
        "the report.json of a probe",
    )
    plate.add_argument(
        "--camera",
        metavar="NAME|FILE",
        help="the camera that took a raw photograph, or its sensitivities (CSV: nm, r, g, b)",
    )
    plate.add_argument("--exposure-s", type=positive_number, metavar="S", help="exposure time in seconds")
    plate.add_argument("--iso", type=positive_number, help="ISO speed")
    plate.add_argument("--f-number", type=positive_number, metavar="N", help="f-number")
    parser.add_argument(
        "--no-rgb", action="store_true", help="leave out the composite of the ordinary RGB render"
    )
    parser.add_argument(
        "--as-rendered",
        action="store_true",
        help="take the objects with their noise, even where the render was denoised",
    )


def run(arguments: argparse.Namespace) -> Job[dict[str, Any]]:
    """The job that the words ask for."""
    from .composite.composite import CompositeSettings, composite
    from .composite.plate_photo import PlateSettings

    plate = PlateSettings(
        response=arguments.response,
        camera=arguments.camera,
        exposure_s=arguments.exposure_s,
        iso=arguments.iso,
        f_number=arguments.f_number,
    )
    settings = CompositeSettings(plate, rgb=not arguments.no_rgb, denoised=not arguments.as_rendered)
    return composite(arguments.render, arguments.plate, arguments.output, settings)
