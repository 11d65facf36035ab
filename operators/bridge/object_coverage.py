"""Which pixels of a render show which object, by Cycles' cryptomatte.

It is kept with the passes themselves, whose samples it has: what it says of a pixel at an edge is what the premultiplied colours
there are made of, through the same pixel filter, lens and shutter.
"""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import bpy
import numpy as np

from ...spectral_probe.composite_model import ObjectCoverage
from ...spectral_probe.files.cryptomatte import object_shares
from ...spectral_probe.files.image_exr import read_channels
from ...spectral_probe.model import Progress, finish
from ...spectral_probe.render.pass_folder import ALPHA
from .catchers import as_ordinary_surfaces, surfaces
from .pass_output import pass_output
from .pass_settings import pass_settings
from .restore import changed

type Array = np.ndarray[Any, Any]

_ALL = ""
"""Key, no object's name, of all that a pixel shows."""

_LEAST_SHARE = 1e-6
"""Share of a pixel that rounding may leave of nothing."""


def object_coverage(scene: bpy.types.Scene, samples: int | None = None) -> ObjectCoverage:
    """How much of each pixel of a scene's first view layer shows which object.

    Parameters
    ----------
    scene
        A Cycles scene with a camera. It comes back exactly as it was.
    samples
        Samples per pixel; the scene's own by default.
    """
    found = surfaces(scene)
    with ExitStack() as stack:
        settings = stack.enter_context(pass_settings(scene))
        render_to = stack.enter_context(pass_output(scene, settings.layers))
        stack.enter_context(as_ordinary_surfaces(scene, found))
        path = Path(stack.enter_context(TemporaryDirectory())) / "objects.exr"
        count = samples or scene.cycles.samples
        settings.set_samples(count, 0, count)
        stack.enter_context(_without_light(scene))
        finish(render_to(Progress(0.0, "Rendering"), path, [], False, mattes=True))
        return coverage_in([(path, count)], 0, *found.names)


def coverage_in(
    files: Sequence[tuple[Path, int]], view_layer: int, catchers: Sequence[str], virtual: Sequence[str]
) -> ObjectCoverage:
    """What renders with cryptomattes say of a view layer.

    Parameters
    ----------
    files
        The renders, each with its number of samples.
    view_layer
        The view layer's number among those rendered.
    catchers, virtual
        Names of the objects that the scene showed, as `Surfaces.names`.

    Returns
    -------
    ObjectCoverage
        With a transparent film, `coverage` is all that hides the background but the ground: smoke too, which no cryptomatte
        shows, and what is behind it counts as much as it is seen.
    """
    names = [*catchers, *virtual]
    planes: dict[str, Array] = {}
    total = sum(samples for _, samples in files)
    for path, samples in files:
        channels, _ = read_channels(path)
        held = object_shares(channels, names, f"{view_layer}.")
        hides = channels.get(f"{view_layer}.{ALPHA}.V")
        if hides is None:
            nothing = np.zeros(next(iter(channels.values())).shape, np.float32)
            hides = sum(held.values(), start=nothing)
        for name, plane in {**held, _ALL: hides}.items():
            part = np.float32(samples / total) * np.asarray(plane, np.float32)
            planes[name] = planes[name] + part if name in planes else part
    alpha = np.clip(planes[_ALL], 0.0, 1.0)
    ground = sum((planes[name] for name in catchers), start=np.zeros_like(alpha))
    ground = np.clip(ground, 0.0, alpha)
    coverage = alpha - ground
    coverage[coverage < _LEAST_SHARE] = 0.0
    objects = {name: np.clip(planes[name], 0.0, 1.0) for name in virtual}
    return ObjectCoverage(objects, coverage, ground)


@contextmanager
def _without_light(scene: bpy.types.Scene) -> Iterator[None]:
    """No light, and no ray beyond the first surface that is not transparent, while the block runs."""
    with ExitStack() as stack:
        stack.enter_context(changed(scene, world=None))
        stack.enter_context(changed(scene.render, film_transparent=True))
        stack.enter_context(changed(scene.cycles, film_transparent_glass=False, max_bounces=0))
        yield
