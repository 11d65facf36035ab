"""The words of the verb `compare`, and what they start."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

from .cli_render import frame_list
from .cli_spectrum import bearing
from .errors import FileFormatError
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
        "spectral",
        type=Path,
        metavar="SPECTRAL.exr|DIR",
        help="xyz.exr or image.exr of a spectral render; or a folder of frames, each compared, with a contact sheet",
    )
    parser.add_argument("rgb", type=Path, nargs="?", metavar="RGB.exr", help="rgb.exr of the same scene")
    parser.add_argument(
        "--frames",
        type=frame_list,
        metavar="LIST",
        help="of a folder: these frames, such as 1-24 (default: all)",
    )
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

    if arguments.rgb is None:
        return _frames(arguments)
    if arguments.frames is not None:
        raise FileFormatError(
            "--frames belongs to a folder of frames. Give the folder alone, or leave --frames out."
        )
    settings = CompareSettings(
        arguments.blur,
        arguments.light,
        arguments.at,
        arguments.region,
        tuple(arguments.metals),
        arguments.split,
    )
    return compare(arguments.spectral, arguments.rgb, arguments.output, settings)


def _frames(arguments: argparse.Namespace) -> Job[Numbers]:
    """Compare a folder of frames.

    Raises
    ------
    FileFormatError
        If it is none, or words were given that belong to a single comparison.
    """
    from .compare_frames import compare_frames

    folder = arguments.spectral
    if not folder.is_dir():
        raise FileFormatError(
            f"{folder} is no folder of frames. Give one, or an RGB render to compare it with."
        )
    of_one = arguments.light, arguments.at, arguments.region, tuple(arguments.metals), arguments.split
    if of_one != ("", None, None, _METALS, 0.5):
        raise FileFormatError(
            "--split, --light, --at, --region and --metals belong to one render's comparison. Leave them out for frames."
        )
    return compare_frames(folder, arguments.output, arguments.frames, blur_px=arguments.blur)


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
