"""Which pixels of a render show which object: Cycles' cryptomatte of one extra render that follows no light.

It takes the samples of the render itself, through the same pixel filter, lens and shutter: what it says of a pixel at an edge
is what the render's premultiplied colours there are made of.
"""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import bpy
import numpy as np

from ...spectral_probe.composite_model import ObjectCoverage
from ...spectral_probe.files.cryptomatte import read_cryptomatte
from ...spectral_probe.files.image_exr import read_channels
from ...spectral_probe.render.pass_folder import ALPHA
from .catchers import Surfaces, as_ordinary_surfaces, surfaces
from .pass_output import RenderTo, pass_output
from .pass_settings import pass_settings
from .restore import changed

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
        render_coverage(scene, render_to, path)
        return coverage_in(path, 0, found)


def render_coverage(scene: bpy.types.Scene, render_to: RenderTo, path: Path) -> None:
    """Render which pixels show which object, of all view layers, with the samples that are set."""
    with _without_light(scene):
        render_to(path, [], False, mattes=True)


def coverage_in(path: Path, view_layer: int, found: Surfaces) -> ObjectCoverage:
    """What a file of `render_coverage` says of a view layer.

    Parameters
    ----------
    path
        The file.
    view_layer
        The view layer's number among those rendered.
    found
        What the scene showed.

    Returns
    -------
    ObjectCoverage
        `coverage` is all that hides the background but the ground: smoke too, which no cryptomatte shows, and what is behind it
        counts as much as it is seen.
    """
    names = [thing.name for thing in (*found.catchers, *found.virtual)]
    shares = read_cryptomatte(path, names, f"{view_layer}.")
    channels, _ = read_channels(path)
    alpha = np.clip(np.asarray(channels[f"{view_layer}.{ALPHA}.V"], np.float32), 0.0, 1.0)
    nothing = np.zeros_like(alpha)
    ground = sum((shares[thing.name] for thing in found.catchers), start=nothing)
    ground = np.clip(ground, 0.0, alpha)
    coverage = alpha - ground
    coverage[coverage < _LEAST_SHARE] = 0.0
    objects = {thing.name: np.clip(shares[thing.name], 0.0, 1.0) for thing in found.virtual}
    return ObjectCoverage(objects, coverage, ground)


@contextmanager
def _without_light(scene: bpy.types.Scene) -> Iterator[None]:
    """No light, and no ray beyond the first surface that is not transparent, while the block runs."""
    with ExitStack() as stack:
        stack.enter_context(changed(scene, world=None))
        stack.enter_context(changed(scene.render, film_transparent=True))
        stack.enter_context(changed(scene.cycles, film_transparent_glass=False, max_bounces=0))
        yield
