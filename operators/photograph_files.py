"""Which files a drop or a file browser gave: photographs, capture files, and what is neither."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import bpy

from ..spectral_probe.errors import CaptureError, PhotographError
from ..spectral_probe.model import Capture, Job, Progress
from ..spectral_probe.photo.suffixes import PHOTOGRAPHS, RAW

if TYPE_CHECKING:  # heavy: imported where it is used
    from ..spectral_probe.photo.grouping import Grouping

CAPTURE_SUFFIX = ".toml"

DROPPED_SUFFIXES = ";".join((CAPTURE_SUFFIX, *PHOTOGRAPHS))
"""For a FileHandler."""

BROWSED = ";".join(f"*{suffix}" for suffix in (CAPTURE_SUFFIX, *RAW))
"""For a file browser, which knows all other pictures by itself: its own pattern may have 255 letters."""

_SHOWN_EVERY_S = 0.1  # a step is drawn in a twentieth of a second: not one for each file
_MOST_CAPTURE_FILES = 20


@dataclass(frozen=True)
class Found:
    """What the files gave: a capture file and its content, or photographs in views; `refused` says why others were left out.

    `camera` is the name of the camera of raw photographs, where all are of one that is known.
    """

    grouping: Grouping
    capture: tuple[Path, Capture] | None = None
    camera: str = ""
    refused: tuple[str, ...] = ()


def chosen_files(directory: str, names: Iterable[str], filepath: str) -> list[Path]:
    """Absolute paths of what was chosen, each once; a folder stands for the photographs in it.

    Raises
    ------
    CaptureError
        If nothing was chosen, or a folder holds no photograph.
    """
    folder = Path(bpy.path.abspath(directory)) if directory else None
    chosen = [folder / name for name in names if name] if folder is not None else []
    if not chosen and filepath and Path(bpy.path.abspath(filepath)) != folder:
        chosen = [Path(bpy.path.abspath(filepath))]
    if not chosen and folder is not None:
        chosen = [folder]
    if not chosen:
        raise CaptureError("Choose at least one photograph.")
    files = [file for path in chosen for file in (_in_folder(path) if path.is_dir() else [path])]
    return list(dict.fromkeys(files))


def _in_folder(folder: Path) -> list[Path]:
    """Photographs and capture files of a folder; of its folders, where it has none itself."""
    try:
        found = _useful(folder)
        if not any(path.suffix.lower() in PHOTOGRAPHS for path in found):
            found += [path for inner in sorted(folder.iterdir()) if inner.is_dir() for path in _useful(inner)]
    except OSError as problem:
        raise CaptureError(
            f"{folder} cannot be read ({problem.strerror}). Check its permissions and its disk."
        ) from problem
    if not found:
        raise CaptureError(
            f"There is no photograph in {folder}. Choose photographs, or a folder that has some."
        )
    return found


def _useful(folder: Path) -> list[Path]:
    return [
        path
        for path in sorted(folder.iterdir())
        if path.suffix.lower() in (CAPTURE_SUFFIX, *PHOTOGRAPHS)
        and path.is_file()
        and not path.name.startswith(".")
    ]


def look_at(paths: Sequence[Path], *, use_capture_file: bool, library: Path | None) -> Job[Found]:
    """Read what the files say, and sort photographs into views. Touches no Blender data.

    A capture file among them, or where asked for one beside them that names exactly these photographs, goes before.
    `library` is the user's folder, which may have cameras.
    """
    from ..spectral_probe.photo.grouping import group_photographs
    from ..spectral_probe.photo.metadata import read_record

    refused, records = [], []
    capture, not_captures = _capture_among([path for path in paths if path.suffix.lower() == CAPTURE_SUFFIX])
    refused += not_captures
    photographs = [path for path in paths if path.suffix.lower() != CAPTURE_SUFFIX]
    shown = 0.0
    for done, path in enumerate(photographs):
        if time.monotonic() - shown > _SHOWN_EVERY_S:
            yield Progress(done / len(photographs), path.name)
            shown = time.monotonic()
        try:
            records.append(read_record(path))
        except PhotographError as problem:
            refused.append(str(problem))
    grouping = group_photographs(records)
    if capture is None and use_capture_file:
        capture = _capture_beside([photo.path for view in grouping.views for photo in view.photos])
    return Found(grouping, capture, _camera_of(grouping, library), tuple(refused))


def _camera_of(grouping: Grouping, library: Path | None) -> str:
    """The name of the camera of raw photographs; empty where there are none, or it is not known."""
    from ..spectral_probe.spectra.camera_names import LIBRARY_CAMERAS, library_camera

    raw = any(record.encoding == "raw" for view in grouping.views for record in view.photos)
    if not raw or len(grouping.cameras) != 1:
        return ""
    own: Iterable[str] = ()
    if library is not None:
        from ..spectral_probe.spectra.camera import cameras_in

        own = cameras_in(library)
    return library_camera(grouping.cameras[0], (*LIBRARY_CAMERAS, *own)) or ""


def _capture_among(paths: Sequence[Path]) -> tuple[tuple[Path, Capture] | None, list[str]]:
    """The one capture file that was given, and what is said of other TOML files."""
    from ..spectral_probe.files.capture import load_capture

    if len(paths) == 1:
        return (paths[0], load_capture(paths[0])), []
    read, problems = [], []
    for path in paths:
        try:
            read.append((path, load_capture(path)))
        except CaptureError as problem:
            problems.append(str(problem))
    if len(read) > 1:
        names = ", ".join(path.name for path, _ in read)
        raise CaptureError(f"These are {len(read)} capture files ({names}). Give one of them.")
    if paths and not read:
        raise CaptureError(problems[0])
    return (read[0] if read else None), problems


def _capture_beside(photographs: Sequence[Path]) -> tuple[Path, Capture] | None:
    """The capture file in the photographs' folder that names all of them and no others."""
    from ..spectral_probe.files.capture import load_capture

    folders = {path.parent for path in photographs}
    if len(folders) != 1:
        return None
    given = {path.resolve() for path in photographs}
    for path in sorted(folders.pop().glob(f"*{CAPTURE_SUFFIX}"))[:_MOST_CAPTURE_FILES]:
        try:
            capture = load_capture(path)
        except CaptureError:
            continue  # nobody asked for this file
        if {photo.resolve() for view in capture.views for photo in view.photos} == given:
            return path, capture
    return None
