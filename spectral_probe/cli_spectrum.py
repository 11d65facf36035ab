"""The words of the verb `spectrum`, and what they start."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

from .model import Job

if TYPE_CHECKING:
    from .spectrum_command import Numbers

TEXT = "The spectrum of the light from one direction or region: numbers, CSV and plot."
EXAMPLE = "spectrum out/probe.exr --at 30,45 --measured lamp.csv"


def add_words(parser: argparse.ArgumentParser) -> None:
    """Give the verb its words."""
    parser.add_argument(
        "probe",
        type=Path,
        metavar="PROBE.exr",
        help="a recovered probe, or a spectral panorama of another program",
    )
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument(
        "--at", type=bearing, metavar="AZIMUTH,ELEVATION", help="compass bearing and elevation in degrees"
    )
    where.add_argument(
        "--region", type=Path, metavar="REGION.json", help="mean over a region in place of --at"
    )
    parser.add_argument("--measured", type=Path, metavar="FILE", help="a measured spectrum to compare with")
    parser.add_argument(
        "--radius", type=_radius, default=0.5, help="degrees about --at to average over (default 0.5)"
    )
    parser.add_argument("--basis", action="store_true", help="draw the basis functions used there too")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="DIR", help="folder to write to (default: the probe's)"
    )


def run(arguments: argparse.Namespace) -> Job[Numbers]:
    """The job that the words ask for."""
    from .spectrum_command import spectrum

    return spectrum(
        arguments.probe,
        arguments.at,
        arguments.measured,
        arguments.output,
        arguments.radius,
        region_path=arguments.region,
        basis=arguments.basis,
    )


def bearing(text: str) -> tuple[float, float]:
    """Compass bearing and elevation in degrees, for argparse.

    Examples
    --------
    >>> bearing("-30,45")
    (330.0, 45.0)
    """
    try:
        azimuth, elevation = (float(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f'"{text}" is no bearing such as 30,45') from None
    if not (-90 <= elevation <= 90 and math.isfinite(azimuth)):
        raise argparse.ArgumentTypeError(
            f"{text}: the elevation is not between -90 and 90 degrees, or the bearing no number"
        )
    return azimuth % 360.0, elevation


def _radius(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value <= 90:
        raise argparse.ArgumentTypeError(f'"{text}" is no radius above 0 and up to 90 degrees')
    return value
