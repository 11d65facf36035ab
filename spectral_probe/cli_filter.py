"""The words of the verb `filter`, and what they start."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from .errors import SpectralDataError
from .model import Job

if TYPE_CHECKING:
    from .editing import Numbers

TEXT = "Stained glass before a region of a probe, or another lamp in it; all of it can be taken back."
EXAMPLE = "filter out/probe.exr --glass red --region window.json -o out/stained.exr"
_REGIONS = '{"polygon_deg": [[az, el], ...]}, {"mask": "m.png"} or {"seed_deg": [az, el]}, bearings and elevations in degrees'


def add_words(parser: argparse.ArgumentParser) -> None:
    """Give the verb its words."""
    parser.add_argument(
        "probe", type=Path, metavar="PROBE.exr", help="a recovered probe, edited before or not"
    )
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument(
        "--glass", metavar="NAME|FILE", help="red, yellow, green, ... or a transmittance (CSV: nm, 0..1)"
    )
    what.add_argument(
        "--lamp", metavar="NAME|FILE", help="a light of the library, or a spectrum (CSV: nm, power)"
    )
    what.add_argument("--list", action="store_true", help="list the edits of the probe")
    what.add_argument(
        "--remove", type=_number, metavar="N|all", help="take an edit back, as numbered by --list"
    )
    parser.add_argument("--region", type=Path, metavar="REGION.json", help=f"where: {_REGIONS}")
    parser.add_argument(
        "--keep",
        choices=("luminance", "power", "surfaces"),
        default="luminance",
        help="what of the light stays under another lamp: the colours of surfaces in its light need --was (default luminance)",
    )
    parser.add_argument(
        "--was", metavar="NAME|FILE", help="with --keep surfaces, the lamp that the new one replaces"
    )
    parser.add_argument("-o", "--output", type=Path, metavar="OUT.exr", help="the edited probe to write")
    parser.add_argument("--preview", type=Path, metavar="FILE.png", help="write a picture of it too")


def run(arguments: argparse.Namespace) -> Job[Numbers]:
    """The job that the words ask for.

    Raises
    ------
    SpectralDataError
        If a word that it needs is missing.
    """
    from . import editing

    if arguments.list:
        return editing.list_edits(arguments.probe)
    if arguments.output is None:
        raise SpectralDataError("Say where to write the edited probe: give -o OUT.exr.")
    if arguments.remove is not None:
        return editing.take_back(arguments.probe, arguments.remove, arguments.output, arguments.preview)
    if arguments.region is None:
        raise SpectralDataError("Say where: give --region REGION.json.")
    if arguments.was is not None and (arguments.lamp is None or arguments.keep != "surfaces"):
        raise SpectralDataError(
            "--was names the lamp that another replaces: give --lamp and --keep surfaces with it."
        )
    change = (
        editing.Change("glass", arguments.glass)
        if arguments.glass is not None
        else editing.Change("lamp", arguments.lamp, arguments.keep, arguments.was)
    )
    return editing.add_edit(arguments.probe, change, arguments.region, arguments.output, arguments.preview)


def _number(text: str) -> int | str:
    if text == "all":
        return text
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f'"{text}" is no number of an edit; they count from 1')
    return int(text)
