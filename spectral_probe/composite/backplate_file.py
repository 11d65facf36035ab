"""backplate.json: the photograph behind a render, the camera that took it, and where that stood."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..composite_model import Backplate
from ..errors import FileFormatError
from ..files.atomic import written_whole
from ..files.json_object import UNREADABLE, read_object
from ..model import FloatArray
from .probe_views import absolute_path, camera_from_table, camera_table, finite_array, relative_path

_VERSION = 1


def save_backplate(path: Path, backplate: Backplate) -> None:
    """Write a backplate as JSON; paths of files become relative to it where they can.

    Parameters
    ----------
    path
        The file to write, usually `composite_model.BACKPLATE_NAME` in a render's folder.
    backplate
        What to write.

    Raises
    ------
    FileFormatError
        If it cannot be written there.
    """
    path = Path(path)
    with written_whole(path) as temporary:
        text = json.dumps(backplate_table(backplate, path.resolve().parent), indent=1)
        temporary.write_text(text + "\n", encoding="utf-8")


def load_backplate(path: Path) -> Backplate:
    """Read what `save_backplate` wrote.

    Raises
    ------
    FileFormatError
        If the file is missing or holds something else.
    """
    path = Path(path)
    if not path.is_file():
        raise FileFormatError(f"There is no backplate {path}. Make one with the verb `backplate`.")
    try:
        table = read_object(path)
        return backplate_from(table, path.resolve().parent)
    except UNREADABLE:
        raise FileFormatError(
            f"{path.name} does not describe a backplate. Make it anew with the verb `backplate`."
        ) from None


def backplate_table(backplate: Backplate, folder: Path) -> dict[str, Any]:
    """A backplate as JSON can hold it; paths are relative to `folder` where they can be."""
    return {
        "version": _VERSION,
        "camera": camera_table(backplate.camera),
        "rotation": _listed(backplate.rotation),
        "position_m": _listed(backplate.position_m),
        "photo": relative_path(backplate.photo, folder),
        "photo_size_px": list(backplate.photo_size_px),
        "frame_px": list(backplate.frame_px),
        "ball_centre_m": _listed(backplate.ball_centre_m),
        "ball_radius_m": backplate.ball_radius_m,
        "camera_model": backplate.camera_model,
        "sensitivities": None
        if backplate.sensitivities is None
        else relative_path(backplate.sensitivities, folder),
        "response_log_gain": _listed(backplate.response_log_gain),
        "exposure": backplate.exposure,
        "gain": _listed(backplate.gain),
    }


def backplate_from(table: Mapping[str, Any], folder: Path) -> Backplate:
    """The backplate that parsed JSON describes; relative paths are from `folder`.

    Raises
    ------
    KeyError, TypeError, ValueError
        If it describes none.
    """
    if table["version"] != _VERSION:
        raise ValueError("of another version")
    left, top, frame_width, frame_height = table["frame_px"]
    ball, response, curves = table["ball_centre_m"], table["response_log_gain"], table["sensitivities"]
    return Backplate(
        camera=camera_from_table(table["camera"]),
        rotation=finite_array(table["rotation"], (3, 3)),
        position_m=finite_array(table["position_m"], (3,)),
        photo=absolute_path(table["photo"], folder),
        photo_size_px=_two_whole(table["photo_size_px"]),
        frame_px=(float(left), float(top), int(frame_width), int(frame_height)),
        ball_centre_m=None if ball is None else finite_array(ball, (3,)),
        ball_radius_m=float(table["ball_radius_m"]),
        camera_model=str(table["camera_model"]),
        sensitivities=None if curves is None else absolute_path(curves, folder),
        response_log_gain=None if response is None else finite_array(response, (3, len(response[0]))),
        exposure=float(table["exposure"]),
        gain=finite_array(table["gain"], (3,)),
    )


def _listed(values: FloatArray | None) -> Any:
    return None if values is None else np.asarray(values, float).tolist()


def _two_whole(values: Any) -> tuple[int, int]:
    first, second = values
    return int(first), int(second)
