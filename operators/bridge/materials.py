"""Materials and lamps for one wavelength after another, on temporary copies: the user's node trees are never edited.

What a material becomes is chosen by `Material.spectral_probe`:

- **METAL**: Metallic, Glossy and Principled shaders become the Metallic BSDF with the metal's complex refractive index
  (exact Fresnel in each channel); roughness, distribution and normal stay.
- **REFLECTANCE**: the colour of Diffuse, Principled, Subsurface and Translucent shaders becomes the measured reflectance.
- **GLASS**: the colour of Transparent, Glass and Refraction shaders becomes the transmittance of a pane, or the body absorbs.
- **DISPERSIVE**: the refractive index of Glass and Refraction shaders follows the wavelength.
- **RGB** (the default), and all other shaders of the above: every colour is uplifted to a reflectance by Mallett & Yuksel
  (2019), textures and other linked colours by dot products behind the link.

Light that lamps and materials emit: see `emission`.
"""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np

from ...spectral_probe.render_model import EmissionGroup
from ...spectral_probe.spectra.grid import WAVELENGTHS_NM
from .emission import UNTRANSLATED, Emission, Source, sources_of
from .glass import translate_dispersive, translate_glass
from .hair import translate_melanin
from .light_groups import light_groups, shown_by
from .rgb_twin import metal_colours, rgb_materials
from .shaders import link_of, shaders
from .spectral_kinds import index_spectra, translate_metal, translate_reflectance
from .stand_ins import Copy, lamp_copies, material_copies, naming
from .translation import COEFFICIENTS, Translation, index_rows, working_to_rec709
from .untranslated import name_untranslated

__all__ = ["SpectralMaterials", "metal_colours", "rgb_materials", "spectral_materials", "working_to_rec709"]

type Array = np.ndarray[Any, Any]


@dataclass
class SpectralMaterials:
    """The scene's materials and lamps, ready to be set to wavelengths.

    Parameters
    ----------
    spectra
        (n, 61) each: the reflectances that occur, for the plan.
    warnings
        What was not translated exactly, one sentence each.
    dispersive
        Whether a refractive index changes with the wavelength: passes then see different directions.
    emission
        Light groups of lamps and emitting materials; none in a wavelength pass.
    emitters
        What emits light, such as 'Lamp "Sun"'.
    """

    spectra: list[Array]
    warnings: list[str]
    dispersive: bool
    emission: tuple[EmissionGroup, ...]
    emitters: tuple[str, ...]
    _setters: list[Callable[[Array], None]] = field(repr=False)
    _shine: Callable[[bool], None] = field(repr=False)

    def set_wavelengths(self, wavelengths_nm: Array) -> None:
        """Set channel c of every material to ``wavelengths_nm[c]``."""
        for setter in self._setters:
            setter(np.asarray(wavelengths_nm, float))

    def shine(self, on: bool) -> None:
        """Switch lamps and emitting materials on (the first light set, and at the start) or off (the others)."""
        self._shine(on)


@contextmanager
def spectral_materials(
    scene: bpy.types.Scene, *, one_wavelength: bool, level: float = 1.0
) -> Iterator[SpectralMaterials]:
    """Stand-ins for all materials and lamps of the scene that can be set to wavelengths, and their light groups.

    Parameters
    ----------
    scene
        The scene to be rendered.
    one_wavelength
        All three channels will always have the same wavelength (light-basis passes): materials are grey, and channels hold
        layers of light. Otherwise channels hold wavelengths, of light and materials alike.
    level
        Radiance per nm that is 1 in the passes, as of the world's light: emission is divided by it, and the spectra of the
        emission groups are multiplied by it.
    """
    with ExitStack() as stack:
        translation = Translation(one_wavelength, level, stack)
        materials = stack.enter_context(material_copies(scene))
        lamps = stack.enter_context(lamp_copies(scene))
        sources: list[Source] = []
        for copy in (*materials, *lamps):
            with naming(copy.label):
                if copy.kind == "Material":
                    _translate(translation, copy)
                sources += sources_of(copy, translation)
        objects = shown_by(scene, [copy.datablock for copy in (*materials, *lamps)])
        emission = Emission(translation, sources, objects)
        names = [group.name for group in emission.groups]
        stack.enter_context(light_groups(scene, names, emission.object_groups))
        yield SpectralMaterials(
            translation.spectra,
            list(dict.fromkeys(translation.warnings)),
            translation.dispersive,
            emission.groups,
            tuple(dict.fromkeys(source.owner.label for source in sources)),
            translation.setters,
            emission.shine,
        )


def _translate(translation: Translation, copy: Copy) -> None:
    """Prepare a material's copy for wavelengths."""
    if not copy.trees:
        translation.warnings.append(f"{copy.label} has no nodes; its viewport colour stays RGB.")
        return
    settings = getattr(copy.datablock, "spectral_probe", None)  # none where the extension is not registered
    kind = settings.kind if settings else "RGB"
    done: set[Any] = set()
    if kind == "METAL":
        done = translate_metal(translation, settings.metal, copy.trees)
    elif kind == "REFLECTANCE":
        done = translate_reflectance(translation, settings.reflectance_path, copy.trees)
    elif kind == "GLASS":
        done = translate_glass(translation, settings, copy.trees)
    elif kind == "DISPERSIVE":
        done = translate_dispersive(translation, settings, copy.label, copy.trees)
    for tree, node in shaders(copy.trees):
        name_untranslated(translation, copy.label, tree, node)
        if node not in done:
            _uplift(translation, copy.label, tree, node, done)


def _uplift(
    translation: Translation, label: str, tree: bpy.types.NodeTree, node: bpy.types.Node, done: set[Any]
) -> None:
    """Every colour of a shader node from the working space to reflectance; what it emits is not one."""
    if node.type == "BSDF_METALLIC" and node.fresnel_type == "PHYSICAL_CONDUCTOR":
        _conductor(translation, label, tree, node)
        return
    if node.type == "BSDF_HAIR_PRINCIPLED" and translate_melanin(translation, label, tree, node):
        return
    for socket in node.inputs if node.type != "EMISSION" else ():
        unused = link_of(socket) is None and not socket.enabled
        if socket in done or unused or socket.name.startswith(UNTRANSLATED):
            continue
        if socket.type == "RGBA":
            translation.bind_colour(label, tree, socket)
        elif socket.type == "VECTOR" and socket.name in COEFFICIENTS:
            translation.bind_coefficients(tree, socket)


def _conductor(translation: Translation, label: str, tree: bpy.types.NodeTree, node: bpy.types.Node) -> None:
    """A Metallic node's refractive index, which the artist gave for three channels."""
    translation.warnings.append(
        f"{label} has a refractive index of three channels only; it was interpolated between 464, 549 "
        "and 611 nm. Choose a metal in the material's Spectral Probe panel for measured ones."
    )
    sockets = [node.inputs["IOR"], node.inputs["Extinction"]]
    n, k = (index_rows(WAVELENGTHS_NM) @ np.asarray(socket.default_value, float) for socket in sockets)
    translation.spectra.append(index_spectra(n, k))
    for socket in sockets:
        translation.bind_index(tree, socket)
