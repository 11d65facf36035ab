"""The words of the verb `render`."""

from __future__ import annotations

import argparse
import re
from pathlib import Path

from .cli_numbers import positive_number, whole_number
from .cli_output import add_output_words
from .cli_swap import add_swappable_words

TEXT = "Render a scene spectrally with a probe's light, or that of its own world."
EXAMPLE = "render SCENE.blend --probe out/probe.exr -o render"

DEFAULT_MAX_DE2000 = 0.5
_MOST_FRAMES = 100_000


def add_words(parser: argparse.ArgumentParser) -> None:
    """Give the verb its words, but for the folder to write to."""
    add_render_words(parser)
    frames = parser.add_mutually_exclusive_group()
    frames.add_argument("--frame", type=int, default=None, help="frame to render (default: the scene's)")
    frames.add_argument(
        "--frames",
        type=frame_list,
        default=None,
        metavar="LIST",
        help="frames of an animation, such as 1-24 or 1,5,10-20, each into a folder of its own, frame_0001 and so on",
    )
    parser.add_argument(
        "--plan-only", action="store_true", help="say the passes and their cost, render nothing"
    )


def add_render_words(parser: argparse.ArgumentParser, *, again: bool = True) -> None:
    """The words that say what is rendered, and how: those of `render_words`; and what to do where there is an unfinished render.

    `again` leaves the latter out where it is False.
    """
    parser.add_argument("scene", type=Path, metavar="SCENE.blend", help="the scene")
    light = parser.add_mutually_exclusive_group(required=True)
    light.add_argument("--probe", type=Path, metavar="PROBE.exr", help="a probe is the light")
    light.add_argument(
        "--world", action="store_true", help="the scene's own world is the light, its sky being daylight"
    )
    _add_plan_words(parser)
    add_swappable_words(parser)
    parser.add_argument("--no-rgb", action="store_true", help="leave out the ordinary RGB render beside it")
    add_output_words(parser)
    if not again:
        return
    changed = parser.add_mutually_exclusive_group()
    changed.add_argument(
        "--restart", action="store_true", help="render anew, whatever the folder has of an unfinished render"
    )
    changed.add_argument(
        "--resume",
        action="store_true",
        help="go on with the passes in the folder as they are, though the scene has changed since",
    )


def _add_plan_words(parser: argparse.ArgumentParser) -> None:
    """How many passes and samples."""
    plan = parser.add_argument_group("passes")
    which = plan.add_mutually_exclusive_group()
    which.add_argument(
        "--passes",
        type=_passes,
        default=None,
        metavar="N|all",
        help="passes of light layers, N wavelengths for every set of layers; or all 61, three a pass (default: as few as "
        "keep the error bound)",
    )
    which.add_argument(
        "--plan",
        type=Path,
        default=None,
        metavar="PLAN.json",
        help="the plan of an earlier render in this light, as its folder has it",
    )
    plan.add_argument(
        "--max-de",
        type=positive_number,
        default=DEFAULT_MAX_DE2000,
        metavar="DE",
        help=f"dE2000 against all 61 wavelengths that 99 of 100 random pixels are to keep (default {DEFAULT_MAX_DE2000:g})",
    )
    plan.add_argument(
        "--samples",
        type=whole_number,
        default=None,
        help="samples a pixel as of an RGB render, none of them adaptive (default: the scene's, 4096 where they were never set)",
    )
    plan.add_argument(
        "--full-samples",
        action="store_true",
        help="give every pass all samples: none shared, no ratios between passes",
    )


def render_words(arguments: argparse.Namespace) -> list[str]:
    """The words again that say what is rendered, and how, without the scene: for another process, and for messages.

    Paths are as they were given. `--restart` and `--resume` are left out: they are said once.

    Examples
    --------
    >>> parser = argparse.ArgumentParser()
    >>> add_render_words(parser)
    >>> render_words(parser.parse_args(["a.blend", "--world", "--samples", "8", "--no-rgb", "--passes=4"]))
    ['--world', '--passes', '4', '--samples', '8', '--no-rgb']
    """
    words = ["--world"] if arguments.world else ["--probe", str(arguments.probe)]
    for name in ("passes", "plan", "samples"):
        value = getattr(arguments, name)
        words += [] if value is None else [f"--{name}", str(value)]
    words += [] if arguments.max_de == DEFAULT_MAX_DE2000 else ["--max-de", repr(arguments.max_de)]
    for name, path in arguments.swappable:
        words += ["--swappable", f"{name}={path}"]
    words += ["--white", arguments.white] if arguments.white else []
    for name in ("full_samples", "swappable_lamps", "no_rgb", "spectral"):
        words += [f"--{name.replace('_', '-')}"] if getattr(arguments, name) else []
    if arguments.denoise is not None:
        words.append("--denoise" if arguments.denoise else "--no-denoise")
    return words


def frame_list(text: str) -> tuple[int, ...]:
    """Frames as people list them: numbers and ranges, with a step after a colon, parted by commas; each once, in the order given.

    Examples
    --------
    >>> frame_list("1-3,10,2,-2--1,20-25:2")
    (1, 2, 3, 10, -2, -1, 20, 22, 24)
    """
    frames: dict[int, None] = {}
    for word in text.split(","):
        match = re.fullmatch(r"\s*(-?\d{1,7})(?:\s*-\s*(-?\d{1,7})(?::(\d{1,7}))?)?\s*", word)
        first, last = (int(match[1]), int(match[2] or match[1])) if match else (1, 0)
        step = int(match[3] or 1) if match else 0
        if not match or last < first or step < 1 or last - first >= _MOST_FRAMES:
            raise argparse.ArgumentTypeError(f'"{word}" is no frame and no range of frames, such as 1-24')
        frames |= dict.fromkeys(range(first, last + 1, step))
    return tuple(frames)


def _passes(text: str) -> int | str:
    return text if text == "all" else whole_number(text)
