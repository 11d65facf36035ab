"""The sample's metals in its plate: gold, silver and copper where the mirrored ball stood, in the gym's own light."""

from pathlib import Path
from typing import Any

import bpy

from ..spectral_probe.composite_model import Backplate
from ..spectral_probe.model import Job, Progress, SpectralPanorama, part

_SAMPLES = 48
_GROUND_M = 3.0
_SCALE = 2.4  # the silver ball is then as high above the floor as the mirrored ball was, at 1.4 m


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
    plain = OutputSettings(denoise=False)  # only the composite is looked at, which is not made of image.exr
    job = spectral_render(scene, panorama, None, render, samples=_SAMPLES, rgb_twin=False, outputs=plain)
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
    add_metals(scene.collection, bearing_deg=view_angles(backplate.rotation)[0], scale=_SCALE)
    return scene
