"""The command line: `spectral-probe VERB ...`.

The verbs that need Blender (`render`, `demo`) are given by the extension's side (`operators/command_line.py`), so that
the core stays free of it; started without them, this module loads the extension from the folder above and starts anew there.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NoReturn

from . import (
    cli_backplate,
    cli_compare,
    cli_composite,
    cli_farm,
    cli_filter,
    cli_frames,
    cli_probe,
    cli_render,
    cli_spectrum,
    cli_swap,
)
from .cli_numbers import positive_number, whole_number
from .cli_progress import SchedulerLines, Terminated, add_openjd_word, ended_by_signal, with_progress
from .errors import PartlyFailedError, SpectralProbeError, printable
from .library_commands import EXAMPLE, add_words, library
from .model import Job

type Numbers = dict[str, Any]
type Verb = Callable[[argparse.Namespace], Job[Numbers]]

BAD_INPUT = 2
STOPPED, TERMINATED = 130, 143
_MOST_NUMBERS = 30
"""Lists of more numbers, such as a spectrum, are told by their length and range; `--json` has them."""
_BLENDER_VERBS = ("backplate", "combine", "demo", "farm", "render", "render-pass")


def main(argv: Sequence[str] | None = None, blender_verbs: Mapping[str, Verb] | None = None) -> int:
    """Run one verb.

    Parameters
    ----------
    argv
        The words after the program's name; None for those of this process.
    blender_verbs
        Jobs of the verbs that need Blender, by name.

    Returns
    -------
    int
        0 on success, 2 after one clear line on bad input, 130 when interrupted.
    """
    words = _joined_bearings(sys.argv[1:] if argv is None else argv)
    arguments = _parser().parse_args(words)
    if arguments.verb in _BLENDER_VERBS and blender_verbs is None:
        return _run_in_extension(words)
    verbs: dict[str, Verb] = {
        "calibrate": _calibrate,
        "probe": cli_probe.run,
        "spectrum": cli_spectrum.run,
        "filter": cli_filter.run,
        "swap": cli_swap.run,
        "composite": cli_composite.run,
        "compare": cli_compare.run,
        "library": library,
        **(blender_verbs or {}),
    }
    with ExitStack() as stack:
        scheduler = SchedulerLines() if getattr(arguments, "openjd", False) else None
        if scheduler is not None:
            stack.callback(scheduler.close)
        try:
            with ended_by_signal():
                numbers = with_progress(verbs[arguments.verb](arguments), scheduler)
        except SpectralProbeError as error:
            if isinstance(error, PartlyFailedError):
                _tell(error.numbers, arguments)
            if scheduler is not None:
                scheduler.fail(str(error))
            sys.stderr.write(f"{error}\n")
            return BAD_INPUT
        except KeyboardInterrupt as stop:
            sys.stderr.write("Stopped. Files already written are whole.\n")
            return TERMINATED if isinstance(stop, Terminated) else STOPPED
    _tell(numbers, arguments)
    return 0


def _run_in_extension(words: Sequence[str]) -> int:
    """Load the extension from its folder, under a name of its own, and run the verb there with Blender."""
    root = Path(__file__).resolve().parents[1]
    name = "spectral_probe_extension"
    spec = importlib.util.spec_from_file_location(
        name, root / "__init__.py", submodule_search_locations=[str(root)]
    )
    if spec is None or spec.loader is None:
        sys.stderr.write(f"The extension is not in {root}. Run this from a whole copy of the project.\n")
        return BAD_INPUT
    extension = importlib.util.module_from_spec(spec)
    sys.modules[name] = extension
    spec.loader.exec_module(extension)
    extension.register()
    try:
        command_line = importlib.import_module(f"{name}.operators.command_line")
        return int(command_line.run(list(words)))
    finally:
        extension.unregister()


# ---------------------------------------------------------------- the words


class _Parser(argparse.ArgumentParser):
    """A parser whose complaints are one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, f"{message[:1].upper()}{message[1:]}. See {self.prog} --help.\n")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="spectral-probe",
        description="Spectral light from photographs of a mirrored ball, and spectral rendering in Cycles.",
    )
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")

    def verb(name: str, text: str, example: str) -> argparse.ArgumentParser:
        added = verbs.add_parser(
            name,
            help=text,
            description=text,
            epilog=f"Example: spectral-probe {example}",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        added.add_argument("--json", action="store_true", help="print the numbers as JSON")
        return added

    demo = verb("demo", "Run the main job on the bundled sample.", "demo -o out")
    _folder(demo, default="out")

    _calibrate_words(
        verb(
            "calibrate",
            "Photographs of a chessboard or ChArUco board to the camera's lens, camera.json.",
            "calibrate board/*.jpg -o camera.json",
        )
    )

    probe = verb("probe", cli_probe.TEXT, cli_probe.EXAMPLE)
    probe.epilog = f"{probe.epilog}\n{cli_probe.FURTHER}"
    cli_probe.add_words(probe)
    _folder(probe)

    cli_spectrum.add_words(verb("spectrum", cli_spectrum.TEXT, cli_spectrum.EXAMPLE))
    cli_filter.add_words(verb("filter", cli_filter.TEXT, cli_filter.EXAMPLE))

    cli_backplate.add_words(verb("backplate", cli_backplate.TEXT, cli_backplate.EXAMPLE))

    render = verb("render", cli_render.TEXT, cli_render.EXAMPLE)
    cli_render.add_words(render)
    _folder(render)

    render_pass = verb("render-pass", cli_frames.TASK_TEXT, cli_frames.TASK_EXAMPLE)
    cli_frames.add_pass_words(render_pass)
    _folder(render_pass, text="folder in which each frame has one of its own, frame_0001 and so on")
    combine = verb("combine", cli_frames.COMBINE_TEXT, cli_frames.COMBINE_EXAMPLE)
    cli_frames.add_combine_words(combine)

    farm = verb("farm", cli_farm.TEXT, cli_farm.EXAMPLE)
    cli_farm.add_farm_words(farm)
    _folder(farm, text="folder of the job")

    cli_swap.add_words(verb("swap", cli_swap.TEXT, cli_swap.EXAMPLE))

    composite = verb("composite", cli_composite.TEXT, cli_composite.EXAMPLE)
    cli_composite.add_words(composite)
    _folder(composite)

    compare = verb("compare", cli_compare.TEXT, cli_compare.EXAMPLE)
    cli_compare.add_words(compare)
    _folder(compare)
    for task in (render_pass, combine, compare):
        add_openjd_word(task)

    add_words(
        verb("library", "Lamps, cameras, metals, glasses, reflectances and balls that are known.", EXAMPLE)
    )
    return parser


def _calibrate_words(calibrate: argparse.ArgumentParser) -> None:
    calibrate.add_argument(
        "photos", type=Path, nargs="+", metavar="PHOTOS", help="ten or more photographs of the board"
    )
    calibrate.add_argument(
        "-o", "--output", type=Path, required=True, metavar="FILE", help="file to write, such as camera.json"
    )
    calibrate.add_argument(
        "--board",
        choices=("auto", "chessboard", "charuco"),
        default="auto",
        help="kind of board (default: seen)",
    )
    calibrate.add_argument("--columns", type=whole_number, help="squares along one side (default: seen)")
    calibrate.add_argument("--rows", type=whole_number, help="squares along the other side (default: seen)")
    calibrate.add_argument("--square-mm", type=positive_number, help="side of a square, for the record only")
    calibrate.add_argument(
        "--marker-mm", type=positive_number, help="side of a ChArUco marker (default: seen)"
    )
    calibrate.add_argument(
        "--dictionary", metavar="NAME", help="ChArUco's markers, such as 5X5_100 (default: seen)"
    )


def _folder(
    parser: argparse.ArgumentParser,
    *,
    default: str | None = None,
    required: bool = True,
    text: str = "folder to write to",
) -> None:
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="DIR",
        help=text,
        default=default and Path(default),
        required=required and not default,
    )


def _joined_bearings(words: Sequence[str]) -> list[str]:
    """Join `--at -30,10` to `--at=-30,10`: argparse would take the value for an option.

    Examples
    --------
    >>> _joined_bearings(["spectrum", "--at", "-30,10"])
    ['spectrum', '--at=-30,10']
    """
    joined: list[str] = []
    for word in words:
        if joined and joined[-1] == "--at" and re.match(r"-[\d.]", word):
            joined[-1] = f"--at={word}"
        else:
            joined.append(word)
    return joined


# ---------------------------------------------------------------- the verbs without Blender


def _calibrate(arguments: argparse.Namespace) -> Job[Numbers]:
    from . import commands
    from .geometry.boards import board_from

    board = board_from(
        arguments.board,
        arguments.columns,
        arguments.rows,
        arguments.square_mm,
        arguments.marker_mm,
        arguments.dictionary,
    )
    return commands.calibrate(arguments.photos, arguments.output, board)


# ---------------------------------------------------------------- what the person sees


def _tell(numbers: Mapping[str, Any], arguments: argparse.Namespace) -> None:
    sys.stdout.write(json.dumps(numbers) + "\n" if arguments.json else _told(numbers))
    sys.stdout.flush()


def _told(numbers: Mapping[str, Any], indent: str = "") -> str:
    """Numbers as lines of text; tables within them are indented, lists of tables numbered."""
    lines = ""
    for key, value in numbers.items():
        name = printable(key).replace("_", " ")
        if isinstance(value, dict):
            lines += f"{indent}{name}:\n{_told(value, indent + '  ')}"
        elif isinstance(value, list) and value and all(isinstance(item, dict) for item in value):
            for number, item in enumerate(value, start=1):
                lines += f"{indent}{name} {number}:\n{_told(item, indent + '  ')}"
        elif (
            isinstance(value, list) and value and all(isinstance(item, str) and " " in item for item in value)
        ):
            lines += f"{indent}{name}:\n" + "".join(
                f"{indent}  {printable(sentence)}\n" for sentence in value
            )
        else:
            lines += f"{indent}{name}: {_plain(value)}\n"
    return lines


def _plain(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.5g}"
    if isinstance(value, list | tuple):
        numbers = _numbers_in(value)
        if len(numbers) > _MOST_NUMBERS:
            return f"{len(numbers)} numbers, {_plain(min(numbers))} to {_plain(max(numbers))}"
        return ", ".join(_plain(item) for item in value)
    return "-" if value is None else printable(str(value))


def _numbers_in(value: object) -> list[float]:
    """The numbers of a list and of lists within it; none where it holds anything else.

    Examples
    --------
    >>> _numbers_in([[1, 2.5], [3.0]]), _numbers_in([1, "two"])
    ([1, 2.5, 3.0], [])
    """
    if isinstance(value, list | tuple):
        parts = [_numbers_in(item) for item in value]
        return [] if not all(parts) else [number for part in parts for number in part]
    return [value] if isinstance(value, int | float) else []
