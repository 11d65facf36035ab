"""A spectral render as a camera sees it: its passes projected through the camera's sensitivities.

The unit is the probe's: a camera's channel is the sum over nm of radiance times sensitivity, as the photographs of the ball are
read (`spectra.recovery`). A photograph's linear pixels are that times its exposure.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..errors import RenderError
from ..files.image_exr import read_channels
from ..model import FloatArray
from ..render.assemble import assemble
from ..render.pass_folder import open_pass_folder, read_pass, render_steps
from ..render.plan_file import load_plan
from ..render.swap import Swap, spectrum_after, swappable_layers
from ..render_model import PassPlan
from ..spectra.camera import REC709, camera_sensitivities
from ..spectra.colorimetry import colour_matching_functions, rec709_to_xyz, spectra_to_xyz, xyz_to_rec709
from ..spectra.grid import STEP_NM, WAVELENGTHS_NM
from ..spectra.library import surface_reflectances
from ..swapping import read_swaps


def camera_rgb(
    render_dir: Path, sensitivities: FloatArray, *, lights_of: Path | None = None
) -> tuple[FloatArray, FloatArray | None]:
    """A render in a camera's linear RGB.

    Parameters
    ----------
    render_dir
        Folder of a spectral render, of whose first view layer this is.
    sensitivities
        (61, 3) of the camera. Rec.709 comes from xyz.exr, others from the passes.
    lights_of
        Folder of the render whose exchanged lights this one is to have; by default its own.

    Returns
    -------
    tuple of ndarray
        (H, W, 3) float32, premultiplied, and alpha (H, W), None with an opaque film.

    Raises
    ------
    SpectralProbeError
        If the folder holds no finished render, or its passes are gone.
    """
    render_dir = Path(render_dir)
    swaps = read_swaps(Path(lights_of or render_dir))
    own = swaps if lights_of is None else read_swaps(render_dir)
    if is_rec709(sensitivities) and _same(swaps, own):
        xyz, alpha = read_xyz(render_dir)
        return xyz_to_rec709(xyz), alpha
    _, alpha = read_xyz(render_dir)
    return _projected(render_dir, np.asarray(sensitivities, float) * STEP_NM, swaps), alpha


def render_xyz(render_dir: Path, *, lights_of: Path | None = None) -> FloatArray:
    """Tristimulus values (H, W, 3) of a render, with the exchanged lights of another folder where one is given."""
    rgb, _ = camera_rgb(render_dir, camera_sensitivities(REC709), lights_of=lights_of)
    return np.asarray(rec709_to_xyz(rgb), np.float32)


def read_xyz(render_dir: Path) -> tuple[FloatArray, FloatArray | None]:
    """What xyz.exr of a render holds: (H, W, 3) and alpha (H, W), None with an opaque film.

    Raises
    ------
    RenderError
        If the render is not finished.
    """
    path = Path(render_dir) / "xyz.exr"
    if not path.is_file():
        raise RenderError(
            f"{render_dir} holds no finished spectral render (xyz.exr). Render the scene first."
        )
    channels, _ = read_channels(path)
    if any(axis not in channels for axis in "XYZ"):
        raise RenderError(f"{path} does not hold X, Y, Z. Render the scene again.")
    alpha = channels.get("A")
    xyz = np.stack([np.asarray(channels[axis], np.float32) for axis in "XYZ"], -1)
    return xyz, None if alpha is None else np.asarray(alpha, np.float32)


def is_rec709(sensitivities: FloatArray) -> bool:
    """Whether the camera is no camera but linear Rec.709 itself.

    Examples
    --------
    >>> is_rec709(camera_sensitivities("Rec.709")), is_rec709(camera_sensitivities("Nikon 5100 (NPL)"))
    (True, False)
    """
    return np.array_equal(sensitivities, camera_sensitivities(REC709))


def camera_to_xyz(sensitivities: FloatArray, rgb: FloatArray, xyz: FloatArray) -> FloatArray:
    """The matrix (3, 3) from a camera's RGB to tristimulus values, ``xyz = rgb @ matrix.T``, for the light of a render.

    No matrix is exact, for no camera's curves are sums of the eye's. This one fits the surfaces of a ColorChecker under the
    light of the scene: the smoothest spectrum that the camera and the eye see as they see the render on average.

    Parameters
    ----------
    sensitivities
        (61, 3) of the camera.
    rgb, xyz
        (..., 3) the render in both.

    Examples
    --------
    >>> grey = spectra_to_xyz(np.ones(61))
    >>> rec709 = camera_sensitivities("Rec.709")
    >>> matrix = camera_to_xyz(rec709, xyz_to_rec709(grey), grey)
    >>> np.allclose(matrix, rec709_to_xyz(np.eye(3)).T)
    True
    """
    if is_rec709(sensitivities):
        return np.asarray(rec709_to_xyz(np.eye(3)).T)
    light = _light_seen(sensitivities, rgb, xyz)
    lit = surface_reflectances() * light
    seen = lit @ (np.asarray(sensitivities, float) * STEP_NM)
    wanted = spectra_to_xyz(lit)
    weight = 1 / wanted[:, 1:2]  # relative errors: dark surfaces count as bright ones do
    return np.asarray(np.linalg.lstsq(seen * weight, wanted * weight, rcond=None)[0].T)


def _light_seen(sensitivities: FloatArray, rgb: FloatArray, xyz: FloatArray) -> FloatArray:
    """The smoothest spectrum (61,) with the mean responses of camera and eye; equal energy for a black render."""
    curves = np.concatenate([np.asarray(sensitivities, float), colour_matching_functions()], 1).T * STEP_NM
    seen = np.concatenate([np.reshape(image, (-1, 3)).mean(0, dtype=float) for image in (rgb, xyz)])
    count = len(WAVELENGTHS_NM)
    if not seen[4] > 0:
        return np.ones(count)
    curves, seen = curves / curves.sum(1, keepdims=True), seen / curves.sum(1)
    bend = np.diff(np.eye(count), 2, axis=0)
    firmly = 30.0
    rows = np.concatenate([bend, firmly * curves])
    light = np.linalg.lstsq(rows, np.concatenate([np.zeros(len(bend)), firmly * seen]), rcond=None)[0]
    return np.asarray(np.maximum(light, 1e-3 * light.max()))


# ---------------------------------------------------------------- from the passes


def _projected(render_dir: Path, projection: FloatArray, swaps: Mapping[str, Swap]) -> FloatArray:
    """The spectrum of every pixel summed by weights (61, 3), from the passes, 61 bands never in memory."""
    folder = open_pass_folder(render_dir / "passes")
    if folder is None:
        raise RenderError(
            f"{render_dir} has no passes, from which colours of a camera come. Render the scene again, and keep its passes."
        )
    plan = _swapped(load_plan(render_dir / "plan.json"), swaps)
    steps = render_steps(plan, folder.record.samples)
    missing = [step.name for step in steps if not folder.path(step.name).is_file()]
    if missing:
        raise RenderError(
            f"{len(missing)} of {len(steps)} passes of {render_dir} are missing ({missing[0]}). Render again."
        )
    found = assemble(plan, steps, lambda step: read_pass(folder.path(step.name)), projection=projection)
    if found.projected is None:
        raise RenderError("The plan has no passes. Make a new one.")
    return np.ascontiguousarray(np.moveaxis(found.projected, 0, -1))


def _swapped(plan: PassPlan, swaps: Mapping[str, Swap]) -> PassPlan:
    """The plan whose passes add up to the render with some of its lights exchanged."""
    if not swaps or plan.interpolation is None:
        return plan
    layers = {layer.name: layer for layer in swappable_layers(plan)}
    reconstruction = np.array(plan.reconstruction)
    for own, layer in zip(plan.swappable, swappable_layers(plan), strict=False):
        if own.name in swaps:
            spectrum = spectrum_after(layer, swaps[own.name])
            for number in (p for p, light_set in enumerate(plan.light_sets) if light_set == own.light_set):
                reconstruction[number, own.channel] = plan.interpolation[number] * spectrum
    emission = []
    for group in plan.emission:
        spectra = np.array(group.spectra)
        for channel, name in enumerate(group.swappable):
            if name in swaps:
                spectra[channel] = spectrum_after(
                    replace(layers[name], spectrum=spectra[channel], recovered=spectra[channel]), swaps[name]
                )
        emission.append(replace(group, spectra=spectra))
    return replace(plan, reconstruction=reconstruction, emission=tuple(emission))


def _same(one: Mapping[str, Swap], other: Mapping[str, Swap]) -> bool:
    return one.keys() == other.keys() and all(
        (one[name].kind, one[name].keeps) == (other[name].kind, other[name].keeps)
        and np.array_equal(one[name].spectrum, other[name].spectrum)
        for name in one
    )
