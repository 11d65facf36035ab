"""The words of the verb `compare`, and what they start."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

from .cli_spectrum import bearing
from .model import Job

if TYPE_CHECKING:
    from .compare_command import Numbers

TEXT = "Compare a spectral with an RGB render: one sheet, map, wipe, numbers by object, metals by four ways of RGB."
EXAMPLE = "compare render/xyz.exr render/rgb.exr -o comparison --light FL11 --split 0.4"

_LARGEST_BLUR_PX = 90.0
_METALS = ("gold", "silver", "copper")


def add_words(parser: argparse.ArgumentParser) -> None:
    """Give the verb its words, but for the folder to write to."""
    parser.add_argument(
        "spectral", type=Path, metavar="SPECTRAL.exr", help="xyz.exr or image.exr of a spectral render"
    )
    parser.add_argument("rgb", type=Path, metavar="RGB.exr", help="rgb.exr of the same scene")
    parser.add_argument(
        "--blur",
        type=_blur,
        default=0.0,
        metavar="PX",
        help="Gaussian blur in pixels against noise (default 0)",
    )
    parser.add_argument(
        "--split",
        type=_share,
        default=0.5,
        help="where the wipe changes to RGB, 0 to 1 of the width (default 0.5)",
    )
    ways = parser.add_argument_group("metals by four ways of RGB (fig. 13)")
    ways.add_argument(
        "--light",
        default="",
        metavar="LIGHT",
        help="a lamp of the library, a file with a spectrum, or a probe (default: the render's mean light, else D65)",
    )
    where = ways.add_mutually_exclusive_group()
    where.add_argument(
        "--at", type=bearing, metavar="AZIMUTH,ELEVATION", help="light of a probe from there, in degrees"
    )
    where.add_argument("--region", type=Path, metavar="REGION.json", help="light of a region of a probe")
    ways.add_argument(
        "--metals",
        nargs="+",
        default=_METALS,
        metavar="METAL",
        help="metals of the library, or pages of refractiveindex.info (default: gold silver copper)",
    )


def run(arguments: argparse.Namespace) -> Job[Numbers]:
    """The job that the words ask for."""
    from .compare_command import CompareSettings, compare

    settings = CompareSettings(
        arguments.blur,
        arguments.light,
        arguments.at,
        arguments.region,
        tuple(arguments.metals),
        arguments.split,
    )
    return compare(arguments.spectral, arguments.rgb, arguments.output, settings)


def _blur(text: str) -> float:
    return _number(text, 0.0, _LARGEST_BLUR_PX)


def _share(text: str) -> float:
    return _number(text, 0.0, 1.0)


def _number(text: str, least: float, most: float) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not least <= value <= most:
        raise argparse.ArgumentTypeError(f'"{text}" is not a number from {least:g} to {most:g}')
    return value
