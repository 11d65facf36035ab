"""The words of the verb `backplate`."""

from __future__ import annotations

import argparse
from pathlib import Path

from .cli_numbers import positive_number, whole_number
from .composite.matching import MatchSettings
from .errors import RenderError
from .model import Exposure

TEXT = "A photograph as the background of a scene: its camera, its ground, and objects where the ball stood."
EXAMPLE = "backplate probe --plate photo.jpg -o scene.blend --object copper-ball"

OBJECTS = ("gold-pedestal", "silver-ball", "copper-ball")


def add_words(parser: argparse.ArgumentParser) -> None:
    """Give the verb its words."""
    parser.add_argument("probe", type=Path, metavar="PROBE", help="folder of a probe")
    parser.add_argument(
        "--plate",
        type=Path,
        required=True,
        metavar="PHOTO",
        help="photograph of the same camera from the same place as those of the ball",
    )
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="SCENE.blend", help="scene to write"
    )
    what = parser.add_mutually_exclusive_group()
    what.add_argument(
        "--scene",
        type=Path,
        metavar="MINE.blend",
        help="put your own scene before the photograph: its origin is where the ball stood, on the ground",
    )
    what.add_argument(
        "--object",
        action="append",
        choices=OBJECTS,
        default=None,
        help="object to put where the ball stood; may be repeated (default copper-ball)",
    )
    parser.add_argument(
        "--size",
        type=positive_number,
        metavar="M",
        help="height of the first object in metres (default: the copper ball as large as the ball was, others to it)",
    )
    parser.add_argument(
        "--view",
        type=whole_number,
        default=1,
        help="view of the probe taken from the plate's place (default 1)",
    )
    parser.add_argument("--width", type=whole_number, metavar="PX", help="reduce the plate to this width")
    parser.add_argument("--no-align", action="store_true", help="do not correct what the camera turned")
    parser.add_argument(
        "--response",
        choices=("measured", "srgb"),
        default="measured",
        help="response curve of a JPEG: that of the ball's photographs, or plain sRGB (default measured)",
    )
    ground = parser.add_argument_group("ground")
    ground.add_argument(
        "--ground-below",
        type=positive_number,
        metavar="M",
        help="distance of the ground below the ball's centre, where the ball stood on something (default: its radius)",
    )
    ground.add_argument(
        "--ground-radius",
        type=positive_number,
        metavar="M",
        help="radius of the ground (default: ten times the ball's)",
    )
    ground.add_argument(
        "--reflectance",
        type=_reflectance,
        metavar="R[,G,B]",
        help="reflectance of the ground, linear Rec.709 (default: estimated from the plate)",
    )
    exposure = parser.add_argument_group("exposure of the plate (default: as it says)")
    exposure.add_argument("--exposure-s", type=positive_number, metavar="S", help="exposure time in seconds")
    exposure.add_argument("--iso", type=positive_number, default=None, help="ISO speed (default 100)")
    exposure.add_argument(
        "--f-number", type=positive_number, default=None, metavar="N", help="aperture (default 1)"
    )


def match_settings(arguments: argparse.Namespace) -> MatchSettings:
    """How the plate is to be matched, of parsed words.

    Raises
    ------
    RenderError
        If ISO or aperture are given without an exposure time.
    """
    exposure = None
    if arguments.exposure_s is not None:
        exposure = Exposure(arguments.exposure_s, arguments.iso or 100.0, arguments.f_number or 1.0)
    elif arguments.iso is not None or arguments.f_number is not None:
        raise RenderError("--iso and --f-number need the exposure time. Give --exposure-s too.")
    return MatchSettings(
        view=arguments.view,
        ground_below_m=arguments.ground_below,
        width_px=arguments.width,
        align=not arguments.no_align,
        exposure=exposure,
        srgb=arguments.response == "srgb",
    )


def _reflectance(text: str) -> tuple[float, float, float]:
    """One number, or three, from 0 to 1.

    Examples
    --------
    >>> _reflectance("0.3"), _reflectance("0.5,0.4,0.3")
    ((0.3, 0.3, 0.3), (0.5, 0.4, 0.3))
    """
    try:
        values = [float(value) for value in text.split(",")]
    except ValueError:
        values = []
    if len(values) not in (1, 3) or not all(0 <= value <= 1 for value in values):
        raise argparse.ArgumentTypeError(f'"{text}" is no reflectance: give one number from 0 to 1, or three')
    red, green, blue = values * (3 // len(values))
    return red, green, blue
