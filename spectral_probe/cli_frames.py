"""The words of the verbs `render-pass` and `combine`, by which a render farm renders frames in parts."""

from __future__ import annotations

import argparse
import re
from pathlib import Path

from .cli_output import add_output_words
from .cli_render import add_render_words, frame_list
from .errors import RenderError
from .render.share import Share, frame_folder

TASK_TEXT = "Render one pass of a frame, or a share of its passes: what a task of a render farm does."
TASK_EXAMPLE = "render-pass SCENE.blend --probe out/probe.exr -o render --frame 7 --pass 3/8"
COMBINE_TEXT = "Put the finished passes of frames together; neither scene nor probe is opened."
COMBINE_EXAMPLE = "combine render --frames 1-24"

_MOST_SHARES = 100_000


def add_pass_words(parser: argparse.ArgumentParser) -> None:
    """Give `render-pass` its words, but for the folder to write to."""
    add_render_words(parser)
    parser.add_argument("--frame", type=int, required=True, metavar="N", help="the frame")
    parser.add_argument(
        "--pass",
        dest="which",
        type=chosen_pass,
        required=True,
        metavar="K/M|NAME",
        help="the K-th of M equal shares of the frame's list of passes, its RGB render last (with M as large as the list, or "
        "larger, one pass each, or nothing); or a pass by its name, such as pass_02, rgb or without/pass_02",
    )


def add_combine_words(parser: argparse.ArgumentParser) -> None:
    """Give `combine` its words."""
    parser.add_argument(
        "folders",
        type=Path,
        nargs="+",
        metavar="DIR",
        help="folders of frames, or of an animation with --frames",
    )
    frames = parser.add_mutually_exclusive_group()
    frames.add_argument("--frame", type=int, default=None, metavar="N", help="the frame in each DIR")
    frames.add_argument(
        "--frames", type=frame_list, default=None, metavar="LIST", help="the frames in each DIR, such as 1-24"
    )
    outputs = parser.add_argument_group("outputs", "As the frames were begun, where none of these is given.")
    add_output_words(outputs)


def chosen_pass(text: str) -> Share | str:
    """A share such as 3/8, or the name of a pass.

    Examples
    --------
    >>> chosen_pass("3/8"), chosen_pass("without/pass_02")
    (Share(number=3, of=8), 'without/pass_02')
    """
    match = re.fullmatch(r"\s*(\d{1,6})\s*/\s*(\d{1,6})\s*", text)
    if match is None:
        if re.fullmatch(r"(without/)?[a-z][a-z0-9_]*", text):
            return text
        raise argparse.ArgumentTypeError(
            f'"{text}" is no share such as 3/8, and no pass such as pass_02 or rgb'
        )
    number, of = int(match[1]), int(match[2])
    if not 1 <= number <= of <= _MOST_SHARES:
        raise argparse.ArgumentTypeError(f'"{text}" is no share: the first of 8 is 1/8, the last 8/8')
    return Share(number, of)


def frames_to_combine(arguments: argparse.Namespace) -> list[Path]:
    """The folders of the frames that the words name, each once.

    Raises
    ------
    RenderError
        If a folder is not there, or is one of an animation whose frames are not given.
    """
    frames = arguments.frames or (() if arguments.frame is None else (arguments.frame,))
    folders: dict[Path, None] = {}
    for folder in arguments.folders:
        if not folder.is_dir():
            raise RenderError(f"There is no folder {folder}. Give the folder of a render.")
        if not frames and not (folder / "passes").is_dir() and any(folder.glob("frame_*/passes")):
            raise RenderError(f"{folder} has a folder for each frame. Say which: --frames 1-24.")
        folders |= dict.fromkeys(frame_folder(folder, frame) for frame in frames)
        folders |= {} if frames else {folder: None}
    return list(folders)
