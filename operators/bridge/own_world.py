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
from ...spectral_probe.render_model import WORLD, LightLayers
from ...spectral_probe.spectra.emission import radiance_of_unit_luminance, rgb_daylights, rgb_illuminants
from ...spectral_probe.spectra.grid import WAVELENGTHS_NM
from .emission import is_dark, light_group, rgb_rows, set_light
from .restore import changed, remove
from .shaders import leading_to_output, link_of, own_trees, set_value, shaders, unlink
from .translation import COEFFICIENTS, Translation, insert_group

type Array = np.ndarray[Any, Any]

_MAP_HEIGHT = 4


@dataclass
class OwnWorld:
    """A world's copy that can be set to wavelengths.

    `spectra` (3, 61) are those of the channels of a light-basis pass, times its level; `level` is what a wavelength pass's
    radiances per nm were divided by; `warnings` name what is not exact.
    """

    spectra: Array
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
        """For the plan: the three spectra, each from some direction and in all mixtures."""
        weights = np.zeros((_MAP_HEIGHT, 2 * _MAP_HEIGHT, 3), np.float32)
        mixtures = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], np.float32)
        weights[:] = np.tile(mixtures, (2, 1))[None]
        return LightLayers(weights, self.spectra, WAVELENGTHS_NM, 0.0)


@contextmanager
def own_world_light(
    scene: bpy.types.Scene, *, one_wavelength: bool, level: float | None = None
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

    Raises
    ------
    RenderError
        If there is no world or it is dark.
    """
    own = scene.world
    if own is None or own.node_tree is None:
        raise RenderError(
            f'Scene "{scene.name}" has no world to be lit by. Add one, or light the scene with a probe.'
        )
    with ExitStack() as stack:
        world = own.copy()
        stack.callback(remove, world)
        world.animation_data_clear()
        world.lightgroup = WORLD
        translation = Translation(one_wavelength, level or radiance_of_unit_luminance(), stack)
        spectra = _translate(translation, f'World "{own.name}"', own_trees(world.node_tree, stack))
        stack.enter_context(changed(scene, world=world))
        yield OwnWorld(
            spectra * translation.rgb_level, list(dict.fromkeys(translation.warnings)), translation
        )


def _translate(translation: Translation, label: str, trees: list[bpy.types.NodeTree]) -> Array:
    """Send a world's colours to the channels of the passes; the spectra (3, 61) of one unit of them."""
    sky = any(node.type == "TEX_SKY" for tree in trees for node in leading_to_output(tree))
    spectra = rgb_daylights() if sky else rgb_illuminants()

    def rows(wavelengths_nm: Array) -> Array:
        return rgb_rows(translation, spectra, wavelengths_nm)

    group = light_group(translation, "Spectral Probe World", rows, clip=True)
    lit = False
    for tree, node in shaders(trees):
        for socket in node.inputs:
            if node.type == "BACKGROUND" and socket.name == "Color":
                lit |= not is_dark(socket) and not is_dark(node.inputs["Strength"])
                _bind(translation, label, tree, socket, group, rows)
            elif socket.type == "RGBA" and not socket.name.startswith(("Emission", "Blackbody")):
                translation.bind_colour(label, tree, socket)
            elif socket.type == "VECTOR" and socket.name in COEFFICIENTS:
                translation.bind_coefficients(tree, socket)
    if not lit:
        raise RenderError(f"{label} is dark. Give its Background a colour, or light the scene with a probe.")
    return spectra


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
