"""The scene's own world as the light of a spectral render: its colours are emission, those of a sky are daylight.

A world is one light of three channels: its Rec.709 colour. They are the weights of three spectra, either those of RGB lamps or,
where the world has a Sky Texture, combinations of the three components of CIE daylight.
"""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ...spectral_probe.errors import RenderError
from ...spectral_probe.model import SpectralPanorama
from ...spectral_probe.render_model import WORLD, LightLayers
from ...spectral_probe.spectra.colorimetry import spectra_to_xyz, xyz_to_rec709
from ...spectral_probe.spectra.emission import radiance_of_unit_luminance, rgb_daylights, rgb_illuminants
from ...spectral_probe.spectra.grid import WAVELENGTHS_NM
from ...spectral_probe.spectra.library import daylight
from .emission import is_dark, light_group, rgb_rows, set_light
from .restore import changed, remove
from .shaders import leading_to_output, link_of, own_trees, set_value, shaders, unlink
from .translation import COEFFICIENTS, Translation, insert_group

type Array = np.ndarray[Any, Any]

_MAP_HEIGHT = 4
_SKY_KELVIN = (4000.0, 5000.0, 6500.0, 9000.0, 14000.0, 25000.0)


@dataclass
class OwnWorld:
    """A world's copy that can be set to wavelengths.

    `spectra` (3, 61) are those of the channels of a light-basis pass, times its level; `mixtures` (M, 3) are weights of them
    that occur, for the plan; `level` is what a wavelength pass's radiances per nm were divided by; `warnings` name what is not
    exact.
    """

    spectra: Array
    mixtures: Array
    warnings: list[str]
    translation: Translation

    def set_wavelengths(self, wavelengths_nm: Array) -> None:
        """Set channel c to ``wavelengths_nm[c]``: light in a wavelength pass, in both kinds the colours of a world's volume."""
        for setter in self.translation.setters:
            setter(np.asarray(wavelengths_nm, float))

    @property
    def level(self) -> float:
        """Radiance per nm that is 1 in the passes."""
        return self.translation.level

    @property
    def layers(self) -> LightLayers:
        """For the plan: each mixture from some direction."""
        weights = np.resize(self.mixtures, (2 * _MAP_HEIGHT, 3)).astype(np.float32)
        return LightLayers(np.tile(weights, (_MAP_HEIGHT, 1, 1)), self.spectra, WAVELENGTHS_NM, 0.0)

    @property
    def panorama(self) -> SpectralPanorama:
        """For the plan: the light of `layers`."""
        layers = self.layers
        sure = np.ones(layers.weights.shape[:2], np.float32)
        return SpectralPanorama(
            layers.weights, self.spectra[None], np.zeros(sure.shape, np.uint8), WAVELENGTHS_NM, sure > 0, sure
        )


@contextmanager
def own_world_light(
    scene: bpy.types.Scene, *, one_wavelength: bool, level: float | None = None, may_be_dark: bool = False
) -> Iterator[OwnWorld]:
    """Light the scene with its own world while the block runs, translated for passes of either kind.

    Parameters
    ----------
    scene
        The scene; its world comes back.
    one_wavelength
        The passes are light-basis passes: channels hold the Rec.709 channels of the world.
    level
        Radiance per nm that is 1 in the passes; by default that of light of Rec.709 value 1.
    may_be_dark
        There is other light, that of lamps.

    Raises
    ------
    RenderError
        If there is no world or it is dark, and no other light.
    """
    own = scene.world
    if own is None and not may_be_dark:
        raise RenderError(
            f'Scene "{scene.name}" has no world and no lamp to be lit by. Add one, or light the scene with a probe.'
        )
    with ExitStack() as stack:
        world = own.copy() if own is not None else _dark_world()
        stack.callback(remove, world)
        world.animation_data_clear()
        world.lightgroup = WORLD
        translation = Translation(one_wavelength, level or radiance_of_unit_luminance(), stack)
        trees = own_trees(world.node_tree, stack)
        sky = any(node.type == "TEX_SKY" for tree in trees for node in leading_to_output(tree))
        spectra = rgb_daylights() if sky else rgb_illuminants()
        label = f'World "{world.name if own is None else own.name}"'
        if not _translate(translation, label, trees, spectra) and not may_be_dark:
            raise RenderError(
                f"{label} is dark and there is no lamp. Give its Background a colour, or light the scene with a probe."
            )
        stack.enter_context(changed(scene, world=world))
        yield OwnWorld(
            spectra * translation.rgb_level,
            _daylight_colours() if sky else np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]]),
            list(dict.fromkeys(translation.warnings)),
            translation,
        )


def _dark_world() -> bpy.types.World:
    world = bpy.data.worlds.new("Spectral Probe Dark")
    world.node_tree.nodes.clear()
    return world


def _daylight_colours() -> Array:
    """(M, 3) Rec.709 colours of phases of daylight, the largest channel 1."""
    colours = xyz_to_rec709(spectra_to_xyz(np.stack([daylight(kelvin) for kelvin in _SKY_KELVIN])))
    return np.maximum(colours / colours.max(-1, keepdims=True), 0.0)


def _translate(translation: Translation, label: str, trees: list[bpy.types.NodeTree], spectra: Array) -> bool:
    """Send a world's colours to the channels of the passes, one unit of them being `spectra` (3, 61); whether it shines."""

    def rows(wavelengths_nm: Array) -> Array:
        return rgb_rows(translation, spectra, wavelengths_nm)

    group = light_group(translation, "Spectral Probe World", rows, clip=True)
    lit = False
    for tree, node in shaders(trees):
        for socket in node.inputs:
            if node.type in {"BACKGROUND", "EMISSION"} and socket.name == "Color":
                lit |= not is_dark(socket) and not is_dark(node.inputs["Strength"])
                _bind(translation, label, tree, socket, group, rows)
            elif socket.type == "RGBA" and not socket.name.startswith(("Emission", "Blackbody")):
                translation.bind_colour(label, tree, socket)
            elif socket.type == "VECTOR" and socket.name in COEFFICIENTS:
                translation.bind_coefficients(tree, socket)
    return lit


def _bind(
    translation: Translation,
    label: str,
    tree: bpy.types.NodeTree,
    socket: bpy.types.NodeSocket,
    group: Any,
    rows: Any,
) -> None:
    link = link_of(socket)
    if link is not None:
        insert_group(tree, link, socket, group)
        return
    colour = translation.rec709(socket.default_value[:3], label, reflectance=False)
    unlink(tree, socket)
    set_light(translation, lambda nm: set_value(socket, np.maximum(rows(nm) @ colour, 0.0)))
