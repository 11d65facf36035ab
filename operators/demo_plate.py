"""The sample's metals in its plate: gold, silver and copper on the floor before the camera, in the gym's own light."""

from pathlib import Path
from typing import Any

import bpy

from ..spectral_probe.composite_model import Backplate
from ..spectral_probe.model import Job, Progress, SpectralPanorama, part

_SAMPLES = 40
_GROUND_M = 6.0
_SCALE = 2.8  # as high as a person
_AHEAD_M, _RIGHT_M = 4.6, -0.3
"""Of the camera: as near as the floor is in the picture, beside the things that lie there and behind none of them."""


def compose_metals(directory: Path, panorama: SpectralPanorama) -> Job[dict[str, Any]]:
    """Render the metals for the plate, with and without, into plate/ and compose them into composite/; its numbers."""
    from ..spectral_probe.composite.backplate_file import save_backplate
    from ..spectral_probe.composite.composite import composite
    from ..spectral_probe.composite_model import BACKPLATE_NAME
    from ..spectral_probe.render.outputs import OutputSettings
    from ..spectral_probe.sample_plate import gym_plate
    from .bridge.cycles import spectral_render

    yield Progress(0.0, "Matching the plate")
    backplate = gym_plate(panorama)
    scene = _scene(backplate, panorama)
    render = directory / "plate"
    smooth = OutputSettings(denoise=True)
    job = spectral_render(scene, panorama, None, render, samples=_SAMPLES, rgb_twin=False, outputs=smooth)
    yield from part(job, 0.05, 0.85)
    save_backplate(render / BACKPLATE_NAME, backplate)
    return (yield from part(composite(render, backplate.photo, directory / "composite"), 0.85, 1.0))


def _scene(backplate: Backplate, panorama: SpectralPanorama) -> bpy.types.Scene:
    """The plate's camera and floor, and the metals on it."""
    from ..spectral_probe.composite.ground import ground_reflectance
    from ..spectral_probe.composite.plate_light import plate_radiance
    from ..spectral_probe.geometry.frames import view_angles
    from ..spectral_probe.photo.read import read_photograph
    from ..spectral_probe.spectra.camera import camera_sensitivities
    from .bridge.backplate import add_ground, match_camera
    from .bridge.objects import add_metals

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    match_camera(scene, backplate)
    plate, valid = plate_radiance(read_photograph(backplate.photo), backplate)
    sensitivities = camera_sensitivities(backplate.camera_model)
    found = ground_reflectance(plate, backplate, panorama, sensitivities, _GROUND_M, valid)
    add_ground(scene, found, _GROUND_M)
    right, _, forward = backplate.rotation.T
    at_m = backplate.position_m + _AHEAD_M * forward + _RIGHT_M * right
    add_metals(scene.collection, (*at_m[:2], 0.0), view_angles(backplate.rotation)[0], _SCALE)
    return scene
