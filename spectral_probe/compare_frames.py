"""The verb `compare` for a folder of frames: every frame's spectral render against its RGB render, and one contact sheet."""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .compare_command import Numbers, compare_pair, read_pair
from .errors import FileFormatError, PartlyFailedError, SpectralProbeError
from .files.atomic import written_together
from .files.lock import folder_lock
from .light_choice import REPORT_NAME, light_of_render
from .model import FloatArray, Job, Progress
from .render.compare import comparison_report
from .render.share import frame_folder
from .spectra.colorimetry import spectra_to_xyz

if TYPE_CHECKING:
    from .figures.contact_sheet import FrameTile, Tiles

CSV_NAME = "comparison.csv"
JSON_NAME = "comparison.json"
SHEET_NAME = "contact_sheet.png"

COLUMNS = (
    "frame", "folder", "status", "message", "width_px", "height_px", "de2000_mean", "de2000_median", "de2000_p95",
    "de2000_p99", "de2000_max", "share_above_1", "share_above_2", "de2000_of_means", "x_shift", "y_shift", "clipped_share",
    "valid_share",
)  # fmt: skip
"""Of comparison.csv. dE2000 is that of the blurred images where a blur was asked for."""

COMPARED, BLACK, FAILED = "compared", "black", "failed"

_FRAME_NAME = re.compile(r"frame_(-?\d{3,8})")
_SPECTRAL_NAME, _RGB_NAME = "xyz.exr", "rgb.exr"
_MOST_REASONS = 5


@dataclass(frozen=True)
class FrameResult:
    """What was found of one frame.

    Parameters
    ----------
    frame
        Its number.
    folder
        The name of its folder.
    status
        `COMPARED`, `BLACK` where both renders are (which is nothing to compare, and no failure), or `FAILED`.
    message
        Why it was not compared, without the frame's name; empty where it was.
    report
        The numbers as `render.compare.comparison_report` tells them, with p99 and the remarks; empty where it was not.
    """

    frame: int
    folder: str
    status: str
    message: str = ""
    report: Numbers | None = None

    @property
    def mean(self) -> float:
        """The mean dE2000 of a compared frame."""
        return float(_quoted(self.report or {})["mean"])


def compare_frames(
    directory: Path, output: Path, frames: Sequence[int] | None = None, *, blur_px: float = 0.0
) -> Job[Numbers]:
    """Every frame of an animation compared, one after another, to comparison.csv, comparison.json and contact_sheet.png.

    Parameters
    ----------
    directory
        A folder with a folder for each frame, frame_0001 and so on.
    output
        The folder to write to; it may be `directory`.
    frames
        Which frames; by default all that have a folder.
    blur_px
        As for two renders.

    Raises
    ------
    FileFormatError
        If there is no frame, or none that can be compared; then nothing is written.
    PartlyFailedError
        If some could not be compared; the others were, and are written.
    """
    chosen = frames_in(directory) if frames is None else tuple(dict.fromkeys(frames))
    with folder_lock(output):
        return (yield from _compare_frames(directory, output, chosen, blur_px))


def frames_in(directory: Path) -> tuple[int, ...]:
    """The frames that have a folder in an animation's folder, ascending.

    Raises
    ------
    FileFormatError
        If there is none.
    """
    try:
        names = [path.name for path in directory.iterdir() if path.is_dir()]
    except OSError as problem:
        raise FileFormatError(
            f"The folder {directory} cannot be read ({problem.strerror}). Give the folder of a render's frames."
        ) from None
    found = (int(match[1]) for match in map(_FRAME_NAME.fullmatch, names) if match)
    frames = sorted(frame for frame in set(found) if frame_folder(directory, frame).name in names)
    if not frames:
        one = (directory / _SPECTRAL_NAME).is_file()
        raise FileFormatError(
            f"There are no frames in {directory} (frame_0001 and so on). "
            + ("For one render, give its xyz.exr and rgb.exr." if one else "Render them first.")
        )
    return tuple(frames)


def _compare_frames(directory: Path, output: Path, frames: Sequence[int], blur_px: float) -> Job[Numbers]:
    from .figures.contact_sheet import Tiles, contact_sheet
    from .figures.style import save_figure

    tiles = Tiles(frames)
    results = []
    for number, frame in enumerate(frames):
        yield Progress(0.9 * number / len(frames), f"Comparing frame {frame}")
        result, tile = _compare_frame(directory, frame, blur_px, tiles)
        results.append(result)
        if tile is not None:
            tiles.add(tile)
    failures = _failures(results)
    if not any(result.status == COMPARED for result in results):
        raise FileFormatError(
            failures or f"Every frame in {directory} is black: there is nothing to compare."
        )
    numbers = _summary(results, blur_px)
    yield Progress(0.92, "Drawing the contact sheet")
    sheet = contact_sheet(
        tiles,
        [(result.frame, result.mean, _p99(result)) for result in results if result.status == COMPARED],
        title=f"Spectral and RGB render compared, frame by frame: {directory.resolve().name}",
        left_out=listed(result.frame for result in results if result.status != COMPARED),
        blur_px=blur_px,
    )
    with written_together(output, last=JSON_NAME) as folder:
        save_figure(sheet, folder / SHEET_NAME)
        (folder / CSV_NAME).write_text(_csv(results), encoding="utf-8")
        rows = [_row(result) | (result.report or {}) for result in results]
        told = json.dumps({**numbers, "rows": rows}, indent=1, allow_nan=False)
        (folder / JSON_NAME).write_text(told + "\n", encoding="utf-8")
    numbers["written"] = str(output)
    if failures:
        raise PartlyFailedError([failures], numbers)
    return numbers


def _compare_frame(
    directory: Path, frame: int, blur_px: float, tiles: Tiles
) -> tuple[FrameResult, FrameTile | None]:
    """One frame's numbers, and its pictures where the contact sheet may show it; its images are let go."""
    folder = frame_folder(directory, frame)
    result = FrameResult(frame, folder.name, FAILED)
    if not folder.is_dir():
        return replace(result, message="there is no such frame"), None
    for name in (REPORT_NAME, _SPECTRAL_NAME, _RGB_NAME):
        if not (folder / name).is_file():
            return replace(result, message=f"{name} is missing"), None
    paths = folder / _SPECTRAL_NAME, folder / _RGB_NAME
    try:
        pair = read_pair(*paths)
        if all(np.isfinite(image.xyz).all() and not (image.xyz > 0).any() for image in pair):
            return replace(result, status=BLACK, message="both renders are black"), None
        comparison, remarks = compare_pair(pair, paths, blur_px)
    except SpectralProbeError as problem:
        return replace(result, message=str(problem)), None
    report = comparison_report(comparison)
    shown = comparison.delta_e_map[comparison.valid]
    report |= {"de2000_p99": float(np.percentile(shown, 99)), "remarks": remarks}
    light = light_of_render(folder)
    white: FloatArray | None = None if light is None else spectra_to_xyz(light.spectrum)
    done = replace(result, status=COMPARED, report=report)
    return done, tiles.tile(frame, done.mean, comparison, (pair[0].xyz, pair[1].xyz), white)


def listed(frames: Iterable[int]) -> str:
    """Frames in few words, ascending.

    Examples
    --------
    >>> listed([1, 2, 3, 7, 9, 10])
    '1-3, 7, 9, 10'
    """
    runs: list[list[int]] = []
    for frame in sorted(frames):
        if runs and frame == runs[-1][-1] + 1:
            runs[-1].append(frame)
        else:
            runs.append([frame])
    words = ([f"{run[0]}-{run[-1]}"] if len(run) > 2 else [str(frame) for frame in run] for run in runs)
    return ", ".join(word for part in words for word in part)


def _failures(results: Sequence[FrameResult]) -> str:
    """One line that names every frame that should have been compared and was not; empty without any."""
    reasons: dict[str, list[int]] = {}
    for result in results:
        if result.status == FAILED:
            reasons.setdefault(result.message, []).append(result.frame)
    if not reasons:
        return ""
    told = [f"{listed(frames)} ({reason.rstrip('.')})" for reason, frames in reasons.items()]
    more = len(told) - _MOST_REASONS
    shown = "; ".join(told[:_MOST_REASONS]) + (f"; and for {more} further reasons others" if more > 0 else "")
    count = sum(len(frames) for frames in reasons.values())
    return (
        f"{count} of {len(results)} frames {'was' if count == 1 else 'were'} not compared: {shown}. "
        "Render or combine them, and compare again."
    )


def _summary(results: Sequence[FrameResult], blur_px: float) -> Numbers:
    """What is told of all frames."""
    compared = [result for result in results if result.status == COMPARED]
    worst = max(compared, key=lambda result: result.mean)
    brightest = max(compared, key=lambda result: _quoted(result.report or {})["max"])
    return {
        "frames": len(results),
        "compared": len(compared),
        "black_frames": [result.frame for result in results if result.status == BLACK],
        "failed_frames": [result.frame for result in results if result.status == FAILED],
        "blur_px": blur_px,
        "de2000_mean": float(np.mean([result.mean for result in compared])),
        "worst_frame": {"frame": worst.frame, "de2000_mean": worst.mean, "de2000_p99": _p99(worst)},
        "largest_pixel": {
            "frame": brightest.frame,
            "de2000_max": _quoted(brightest.report or {})["max"],
        },
    }


def _quoted(report: Numbers) -> Numbers:
    """The whole image's statistics to quote: blurred where there are any, else raw."""
    image: Numbers = report["image"]
    quoted: Numbers = image["blurred"] or image["raw"]
    return quoted


def _p99(result: FrameResult) -> float:
    return float((result.report or {})["de2000_p99"])


def _row(result: FrameResult) -> dict[str, object]:
    """A frame's line of the table; None where there is nothing."""
    row: dict[str, object] = dict.fromkeys(COLUMNS)
    row |= {
        "frame": result.frame,
        "folder": result.folder,
        "status": result.status,
        "message": result.message,
    }
    if result.report is None:
        return row
    quoted, image = _quoted(result.report), result.report["image"]
    width, height = result.report["size_px"]
    shift = image["xy_shift"]
    return row | {
        "width_px": width,
        "height_px": height,
        "de2000_mean": quoted["mean"],
        "de2000_median": quoted["median"],
        "de2000_p95": quoted["p95"],
        "de2000_p99": _p99(result),
        "de2000_max": quoted["max"],
        "share_above_1": quoted["above_1"],
        "share_above_2": quoted["above_2"],
        "de2000_of_means": image["delta_e_of_means"],
        "x_shift": shift[0],
        "y_shift": shift[1],
        "clipped_share": result.report["clipped_fraction"],
        "valid_share": result.report["valid_fraction"],
    }


def _csv(results: Sequence[FrameResult]) -> str:
    text = io.StringIO(newline="")
    table = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    table.writeheader()
    for result in results:
        table.writerow({name: "" if value is None else value for name, value in _row(result).items()})
    return text.getvalue()
