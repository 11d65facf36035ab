"""What putting a frame together needs of its scene, kept when the frame was begun: neither scene nor probe is opened again.

It stands in `passes/index.json` (`pass_folder`), from which other processes and machines read it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..files.json_object import number, numbers, sentences, table, text, texts, truth, whole
from ..model import FloatArray
from ..spectra.grid import WAVELENGTHS_NM
from .outputs import OutputSettings, output_settings

MOST_SAMPLES = 2**31 - 1


@dataclass(frozen=True)
class FrameRecord:
    """What a frame was begun with, as far as its plan and its passes do not say it.

    Parameters
    ----------
    scene
        The scene's name.
    frame
        Number of the frame.
    blend
        Where the .blend lies from the frame's folder; None where it was never saved.
    blender
        Version of Blender.
    samples
        Samples of a full pass.
    to_rec709
        (3, 3) matrix from the working space to linear Rec.709.
    denoise
        Whether the scene's own render settings ask for denoising.
    catchers, virtual
        Names of the objects that stand for real surfaces, and of the others.
    without
        The frame has a second part, the scene without its virtual objects.
    rgb_twin
        The RGB twin belongs to it.
    twin_level
        What the twin's light was divided by; None without a twin.
    light_residual
        Share of the light's energy that its layers do not hold.
    mean_light
        (61,) mean spectrum of the probe; None where the scene's own world is the light.
    backplates
        Descriptions of the camera and its photograph (`composite.backplate_file`): of the whole frame and of one cropped to a
        border, whose size its passes say; None where there is none. Paths are relative to the frame's folder.
    frame_px
        Width and height of the whole frame.
    outputs
        What is written, and how pictures are finished.
    warnings
        Sentences on what was left out, as far as no single step knows better.
    words
        The words of the command line that began it: light, plan and outputs; none where it was begun in a window.
    files
        Digest of the .blend and of the files that it names, where the scene was just opened from it; else "".
    light
        Name of the light layers that tasks share (`light_file`); "" where there are none.
    """

    scene: str
    frame: int
    blend: str | None
    blender: str
    samples: int
    to_rec709: FloatArray
    denoise: bool
    catchers: tuple[str, ...]
    virtual: tuple[str, ...]
    without: bool
    rgb_twin: bool
    twin_level: float | None
    light_residual: float
    mean_light: FloatArray | None
    backplates: tuple[Mapping[str, Any] | None, Mapping[str, Any] | None]
    frame_px: tuple[int, int]
    outputs: OutputSettings
    warnings: tuple[str, ...]
    words: tuple[str, ...] = ()
    files: str = ""
    light: str = ""

    def outputs_for(self, asked: OutputSettings | None = None) -> OutputSettings:
        """What is written: as was said when the frame was begun, but for what is asked for now.

        Pictures are denoised as the scene's render settings say where nobody does.
        """
        asked = asked or OutputSettings()
        denoise = self.outputs.denoise if asked.denoise is None else asked.denoise
        return OutputSettings(
            spectral=asked.spectral or self.outputs.spectral,
            white=asked.white or self.outputs.white,
            denoise=self.denoise if denoise is None else denoise,
        )


def record_table(record: FrameRecord) -> dict[str, Any]:
    """A record as JSON can hold it."""
    white = record.outputs.white
    return {
        "scene": record.scene,
        "frame": record.frame,
        "blend": record.blend,
        "blender": record.blender,
        "samples": record.samples,
        "to_rec709": np.asarray(record.to_rec709, float).tolist(),
        "denoise": record.denoise,
        "catchers": list(record.catchers),
        "virtual": list(record.virtual),
        "without": record.without,
        "rgb_twin": record.rgb_twin,
        "twin_level": record.twin_level,
        "light_residual": record.light_residual,
        "mean_light": None if record.mean_light is None else np.asarray(record.mean_light, float).tolist(),
        "backplates": list(record.backplates),
        "frame_px": list(record.frame_px),
        "outputs": {
            "spectral": record.outputs.spectral,
            "white": "" if white is None else white.stated,
            "denoise": record.outputs.denoise,
        },
        "warnings": list(record.warnings),
        "words": list(record.words),
        "files": record.files,
        "light": record.light,
    }


def record_from(kept: Any, folder: Path) -> FrameRecord:
    """The record that parsed JSON describes; `folder` is the frame's.

    Raises
    ------
    KeyError, TypeError, ValueError, SpectralDataError
        If it describes none.
    """
    kept = table(kept)
    rows = kept["to_rec709"]
    if not isinstance(rows, list) or len(rows) != 3:
        raise TypeError("no matrix")
    to_rec709 = np.array([numbers(row, 3) for row in rows])
    if not abs(np.linalg.det(to_rec709)) > 1e-6:
        raise ValueError("a working space without colours")
    level, mean, blend = kept["twin_level"], kept["mean_light"], kept["blend"]
    twin = truth(kept["rgb_twin"])
    if twin and not number(level) > 0:
        raise ValueError("no level")
    width, height = kept["frame_px"]
    first, second = (_checked_backplate(one, folder) for one in kept["backplates"])
    return FrameRecord(
        scene=text(kept["scene"]),
        frame=whole(kept["frame"], -(2**31)),
        blend=None if blend is None else text(blend),
        blender=text(kept["blender"]),
        samples=whole(kept["samples"], 1, MOST_SAMPLES),
        to_rec709=to_rec709,
        denoise=truth(kept["denoise"]),
        catchers=texts(kept["catchers"]),
        virtual=texts(kept["virtual"]),
        without=truth(kept["without"]),
        rgb_twin=twin,
        twin_level=number(level) if twin else None,
        light_residual=number(kept["light_residual"]),
        mean_light=None if mean is None else np.array(numbers(mean, len(WAVELENGTHS_NM))),
        backplates=(first, second),
        frame_px=(whole(width), whole(height)),
        outputs=_outputs_from(kept["outputs"]),
        warnings=sentences(kept["warnings"]),
        words=sentences(kept["words"]),
        files=text(kept["files"]),
        light=_light_name(kept["light"]),
    )


def _light_name(kept: Any) -> str:
    """The name of a file in the folder of light layers, and of none elsewhere."""
    name = text(kept)
    if name and not re.fullmatch(r"[0-9a-f]{32}", name):
        raise ValueError("no name of light layers")
    return name


def _outputs_from(kept: Any) -> OutputSettings:
    kept = table(kept)
    denoise = kept["denoise"]
    return output_settings(
        spectral=truth(kept["spectral"]),
        white=text(kept["white"]),
        denoise=None if denoise is None else truth(denoise),
    )


def _checked_backplate(kept: Any, folder: Path) -> Mapping[str, Any] | None:
    """A backplate's table, if it describes one."""
    from ..composite.backplate_file import backplate_from

    if kept is None:
        return None
    backplate_from(table(kept), folder)
    return table(kept)
