"""The words of the verb `swap`, and those of `render` that make lights swappable."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .errors import RenderError
from .model import BoolArray, Job, SpectralPanorama

if TYPE_CHECKING:
    from collections.abc import Sequence

TEXT = "Another lamp or another stained glass in a finished render, without rendering again."
EXAMPLE = "swap render --light window --glass green -o green"


def add_words(parser: argparse.ArgumentParser) -> None:
    """Give the verb its words."""
    parser.add_argument("render", type=Path, metavar="RENDER_DIR", help="the folder of a spectral render")
    parser.add_argument("--light", metavar="NAME", help="the swappable region or lamp")
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument(
        "--lamp", metavar="NAME|FILE", help="a light of the library, or a spectrum (CSV: nm, power)"
    )
    what.add_argument(
        "--glass", metavar="NAME|FILE", help="red, yellow, green, ... or a transmittance (CSV: nm, 0..1)"
    )
    what.add_argument("--original", action="store_true", help="the light as it was rendered")
    what.add_argument("--list", action="store_true", help="list the lights that can be exchanged")
    parser.add_argument(
        "--keep",
        choices=("luminance", "power"),
        default="luminance",
        help="what of the light stays under another lamp (default luminance)",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="DIR",
        help="folder for xyz.exr and image.exr (default: that of the render, over its own)",
    )


def run(arguments: argparse.Namespace) -> Job[dict[str, Any]]:
    """The job that the words ask for.

    Raises
    ------
    RenderError
        If no light is named.
    """
    from . import swapping

    if arguments.list:
        return swapping.list_lights(arguments.render)
    if not arguments.light:
        raise RenderError("Say which light: give --light NAME. --list names those that there are.")
    return swapping.swap_light(
        arguments.render,
        arguments.light,
        lamp=arguments.lamp,
        glass=arguments.glass,
        keeps=arguments.keep,
        output=arguments.output,
    )


# ---------------------------------------------------------------- words of render


def add_swappable_words(parser: argparse.ArgumentParser) -> None:
    """The words of `render` that mark regions whose light can be exchanged afterwards."""
    parser.add_argument(
        "--swappable",
        action="append",
        type=_named_region,
        default=[],
        metavar="NAME=REGION.json",
        help="a region of the probe whose lamp or glass can be exchanged after rendering (see swap); may be repeated. "
        "Three layers of such light cost one more set of passes",
    )
    parser.add_argument(
        "--swappable-lamps",
        action="store_true",
        help="let the scene's measured lamps be exchanged after rendering, too: the light is then rendered in layers",
    )


def swappable_masks(arguments: argparse.Namespace, panorama: SpectralPanorama | None) -> dict[str, BoolArray]:
    """The regions that --swappable names, as masks (H, W) of a panorama by name; None is the scene's own world.

    Raises
    ------
    SpectralProbeError
        If a name is given twice, a region cannot be used, or there is no panorama.
    """
    from .files.region_json import read_region
    from .spectra.regions import region_mask

    regions: Sequence[tuple[str, Path]] = arguments.swappable
    masks: dict[str, BoolArray] = {}
    if panorama is None:
        if regions:
            raise RenderError(
                "--swappable names regions of a probe's light: give it with --probe, not with --world."
            )
        return masks
    for name, path in regions:
        if name in masks:
            raise RenderError(f'Two swappable regions are called "{name}". Give each a name of its own.')
        masks[name] = region_mask(read_region(path), panorama)
    return masks


def _named_region(text: str) -> tuple[str, Path]:
    name, equals, path = text.partition("=")
    if not (name.strip() and equals and path):
        raise argparse.ArgumentTypeError(f'"{text}" is not NAME=REGION.json, such as window=window.json')
    return name.strip(), Path(path)
