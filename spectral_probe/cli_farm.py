"""The words of the verb `farm`, and the job that they make."""

from __future__ import annotations

import argparse
from pathlib import Path

from .cli_render import DEFAULT_MAX_DE2000, add_render_words, frame_list, render_words
from .farm.job import FarmJob

TEXT = "Write a shot as a job for a render farm: an Open Job Description bundle, or a list of commands."
EXAMPLE = "farm SCENE.blend --probe out/probe.exr --frames 1-240 -o bundle"


def add_farm_words(parser: argparse.ArgumentParser) -> None:
    """Give the verb its words, but for the folder to write to."""
    add_render_words(parser, again=False)
    parser.add_argument(
        "--frames",
        type=frame_list,
        required=True,
        metavar="LIST",
        help="the frames, such as 1-240 or 1,5,10-20:2",
    )
    parser.add_argument(
        "--render",
        type=Path,
        default=None,
        metavar="DIR",
        help="folder that the farm renders the frames to (default: beside the scene, named after it)",
    )
    parser.add_argument(
        "--format",
        choices=("openjd", "commands"),
        default="openjd",
        help="an Open Job Description bundle, or the same tasks as commands.txt, a shell command a line (default openjd)",
    )
    parser.add_argument(
        "--blender",
        default="blender",
        metavar="PROGRAM",
        help="Blender on the farm's machines (default blender)",
    )


def farm_job(
    arguments: argparse.Namespace,
    *,
    samples: int,
    shares: int,
    memory_mib: int,
    gpu: bool,
    files: tuple[Path, ...],
) -> FarmJob:
    """The job that the words ask for, with what the scene told."""
    scene = arguments.scene.resolve()
    return FarmJob(
        scene=scene,
        probe=None if arguments.world else arguments.probe.resolve(),
        frames=tuple(sorted(arguments.frames)),
        shares=shares,
        output=(arguments.render or scene.with_name(f"{scene.stem}_frames")).resolve(),
        samples=samples,
        max_de2000=arguments.max_de,
        plan=None if arguments.plan is None else arguments.plan.resolve(),
        swappable=tuple((name, path.resolve()) for name, path in arguments.swappable),
        words=_further_words(arguments),
        rgb_twin=not arguments.no_rgb,
        blender=arguments.blender,
        memory_mib=memory_mib,
        gpu=gpu,
        files=files,
    )


def _further_words(arguments: argparse.Namespace) -> tuple[str, ...]:
    """The words of `render` that are no parameters of the job."""
    own = {"world": True, "plan": None, "samples": None, "max_de": DEFAULT_MAX_DE2000, "swappable": ()}
    plain = argparse.Namespace(**{**vars(arguments), **own})
    return tuple(render_words(plain)[1:])
