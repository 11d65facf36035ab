"""Light of lamps and emitting materials in spectral passes.

In a light-basis pass the Rec.709 channels of an emission colour are the weights of three illuminant spectra, and a measured lamp
has a channel of its own: its luminance is that of its colour, times its strength. Light groups keep these apart from the world's
layers. In a wavelength pass the channels hold the light at three wavelengths. Values are divided by the level of the passes, so
that a lamp is as bright beside the world's layers as it is in the scene, and spectra are multiplied by it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...preferences import library_folder
from ...spectral_probe.errors import RenderError
from ...spectral_probe.files.spectrum_csv import read_spectrum_csv
from ...spectral_probe.files.spectrum_file import is_spectrum_file
from ...spectral_probe.render.light_groups import RGB_GROUP, Emitter, assign
from ...spectral_probe.render_model import EmissionGroup
from ...spectral_probe.spectra.catalogue import curves_of, find
from ...spectral_probe.spectra.colorimetry import rec709_to_xyz
from ...spectral_probe.spectra.curves import LIGHT
from ...spectral_probe.spectra.emission import of_unit_luminance, rgb_illuminants
from ...spectral_probe.spectra.library import planck
from ...spectral_probe.spectra.uplift import uplift
from .shaders import link_of, set_value, shaders, unlink
from .stand_ins import Copy
from .translation import (
    Setter,
    Translation,
    at,
    colours_upstream,
    dot_products,
    in_rec709,
    insert_group,
    new_group,
    vector_math,
)

type Array = np.ndarray[Any, Any]

EMISSION = {
    "EMISSION": ("Color", "Strength"),
    "BSDF_PRINCIPLED": ("Emission Color", "Emission Strength"),
    "PRINCIPLED_VOLUME": ("Emission Color", "Emission Strength"),
    "VOLUME_COEFFICIENTS": ("Emission Coefficients", None),
}
"""Inputs of a shader that hold the colour and the strength of what it emits."""

UNTRANSLATED = ("Emission", "Emissive", "Blackbody")
"""How inputs begin that hold light, which is not a reflectance."""

LUMINANCE = rec709_to_xyz(np.eye(3))[:, 1]
"""(3,) luminance of one unit of Rec.709 red, green and blue."""


@dataclass
class Source:
    """One emitting shader: its sockets, and its spectrum where it has one by itself.

    Parameters
    ----------
    owner
        The lamp or material.
    tree, colour, strength
        Where its light is set; `strength` is None where the colour holds it.
    filter
        (3,) what a lamp's own colour multiplies the shader's by, in the working space.
    lamp, spectrum
        Name and spectrum (61,) of a measured lamp; "" and None where only the colour is known.
    """

    owner: Copy
    tree: bpy.types.NodeTree
    colour: bpy.types.NodeSocket
    strength: bpy.types.NodeSocket | None
    filter: Array = field(default_factory=lambda: np.ones(3))
    lamp: str = ""
    spectrum: Array | None = None

    @property
    def switch(self) -> bpy.types.NodeSocket:
        """The socket that makes it dark at zero."""
        return self.colour if self.strength is None else self.strength


def lamp_of(text: str) -> Array:
    """Spectrum (61,) of a lamp of the library or of the user's folder by name, or from a file, at luminance 1."""
    if not text:
        raise RenderError(
            "no lamp is given. Choose a lamp of the library or a file with its spectrum, or let the colour decide."
        )
    if is_spectrum_file(text):
        return of_unit_luminance(read_spectrum_csv(Path(bpy.path.abspath(text)), quantity=LIGHT)[0])
    folder = library_folder()
    return of_unit_luminance(curves_of(find(text, "lamp", folder), folder)["relative_power"])


def sources_of(copy: Copy, translation: Translation) -> list[Source]:
    """All that emits in a material or lamp."""
    sources = []
    chosen = chosen_lamp(copy)
    tint, tinted = _lamp_colour(copy.datablock)
    for tree, node in shaders(copy.trees):
        if node.type not in EMISSION:
            continue
        colour_name, strength_name = EMISSION[node.type]
        colour = node.inputs[colour_name]
        source = Source(copy, tree, colour, node.inputs[strength_name] if strength_name else None, tint)
        if is_dark(source.switch) or is_dark(colour):
            continue
        if chosen:
            source.lamp, source.spectrum = chosen, lamp_of(chosen)
        elif tinted:
            source.lamp, source.spectrum = tinted
        else:
            _note_blackbody(source, translation)
        sources.append(source)
    return sources


def chosen_lamp(copy: Copy) -> str:
    """The lamp that the user chose for a light or an emitting material; "" where its colour decides."""
    settings = getattr(copy.datablock, "spectral_probe", None)
    return settings.lamp if settings is not None and settings.light == "LAMP" else ""


def is_dark(socket: bpy.types.NodeSocket) -> bool:
    """Whether a socket's own value, not linked, is zero."""
    value = socket.default_value
    number = np.asarray(value[:3] if socket.type in {"RGBA", "VECTOR"} else value)
    return link_of(socket) is None and not np.any(number)


def _lamp_colour(datablock: bpy.types.ID) -> tuple[Array, tuple[str, Array] | None]:
    """What a lamp multiplies its nodes' colour by, and its spectrum if that is a black body's: behind a gel, if coloured.

    The colour moves into the nodes: the copy is left white.
    """
    if not isinstance(datablock, bpy.types.Light):
        return np.ones(3), None
    colour = np.array(datablock.color, float)
    datablock.color = (1.0, 1.0, 1.0)
    if not datablock.use_temperature:
        return colour, None
    kelvin = datablock.temperature
    of_body = np.array(datablock.temperature_color, float)
    datablock.use_temperature = False
    name, spectrum = planck_name(kelvin), planck(kelvin)
    if np.ptp(colour) > 1e-4 * colour.max():
        gel = np.array(bpy_rec709(colour))
        spectrum = spectrum * uplift(np.maximum(gel, 0.0))
        name += " behind " + ", ".join(f"{channel:.4g}" for channel in gel)
    return colour * of_body, (name, of_unit_luminance(spectrum))


def bpy_rec709(colour: Array) -> Array:
    """A colour (3,) of the working space in Rec.709, unclipped."""
    from mathutils import Color

    return np.array(Color(colour).from_scene_linear_to_rec709_linear(), float)


def planck_name(kelvin: float) -> str:
    """Name of a black body in the library."""
    return f"Planck {kelvin:g} K"


def _note_blackbody(source: Source, translation: Translation) -> None:
    """Give an emission that comes straight from a Blackbody node its Planck spectrum."""
    link = link_of(source.colour)
    while link is not None and link.from_node.type == "REROUTE":
        link = link_of(link.from_node.inputs[0])
    if link is None:
        return
    node = link.from_node
    if node.type == "BLACKBODY" and link_of(node.inputs[0]) is None and np.ptp(source.filter) < 1e-6:
        kelvin = float(node.inputs[0].default_value)
        source.lamp, source.spectrum = planck_name(kelvin), of_unit_luminance(planck(kelvin))
    elif node.type == "BLACKBODY" or any(n.type == "BLACKBODY" for n in _nodes_upstream(link)):
        translation.warnings.append(
            f"{source.owner.label} has light of a Blackbody node whose temperature or colour is changed by other nodes; it "
            "was taken as RGB. Give the node one temperature and link it straight to the emission's colour."
        )


def _nodes_upstream(link: bpy.types.NodeLink) -> list[bpy.types.Node]:
    found = [link.from_node]
    for node in found:  # grows while it is walked
        for socket in node.inputs:
            feeding = link_of(socket)
            if feeding is not None and feeding.from_node not in found:
                found.append(feeding.from_node)
    return found


class Emission:
    """The lamps and emitting materials of a render: their groups, and their light at the wavelengths of a pass."""

    def __init__(
        self,
        translation: Translation,
        sources: Sequence[Source],
        objects: Sequence[tuple[bpy.types.Object, set[bpy.types.ID]]],
    ) -> None:
        """`objects` are objects and the lamps and materials (copies) that they show."""
        self.translation = translation
        self.sources = list(sources)
        self.object_groups: dict[bpy.types.Object, str] = {}
        self._groups: dict[str, bpy.types.NodeTree] = {}
        self._spectra = {s.lamp: s.spectrum for s in self.sources if s.spectrum is not None}
        self._off: list[tuple[Source, bpy.types.NodeSocket | None, Any]] = []
        names = self._assign(objects) if translation.one_wavelength else [s.lamp for s in self.sources]
        for source, name in zip(self.sources, names, strict=True):
            self._bind(source, name)

    def _assign(self, objects: Sequence[tuple[bpy.types.Object, set[bpy.types.ID]]]) -> list[str]:
        """Choose groups and channels; the name of each source's spectrum, "" where it shines as RGB."""
        emitters = [Emitter(source.lamp, self._constant(source)) for source in self.sources]
        emitting = []
        for thing, shown in objects:
            members = frozenset(n for n, s in enumerate(self.sources) if s.owner.datablock in shown)
            if members:
                emitting.append((thing, members))
        assignment = assign(emitters, [members for _, members in emitting])
        self.object_groups = {
            thing: group for (thing, _), group in zip(emitting, assignment.groups, strict=True)
        }
        self.channels = assignment.channels
        self.members = assignment.members
        for source, name in zip(self.sources, assignment.spectra, strict=True):
            if source.lamp and not name:
                self.translation.warnings.append(
                    f'{source.owner.label}: its measured lamp "{source.lamp}" shares an object with more light than a light '
                    "group holds, and was taken as RGB. Put the emitting materials on objects of their own."
                )
        return list(assignment.spectra)

    def _constant(self, source: Source) -> str:
        """Name of the spectrum of a constant colour; its spectrum is noted."""
        if link_of(source.colour) is not None:
            return ""
        colour = self._rec709(source)
        luminance = float(colour @ LUMINANCE)
        if not luminance > 0:
            return ""
        name = "colour " + ", ".join(f"{channel:.4g}" for channel in colour / luminance)
        self._spectra.setdefault(name, colour / luminance @ rgb_illuminants())
        return name

    def _rec709(self, source: Source) -> Array:
        """Constant colour (3,) of a source in Rec.709."""
        return self.translation.rec709(
            source.filter * source.colour.default_value[:3], source.owner.label, reflectance=False
        )

    @property
    def groups(self) -> tuple[EmissionGroup, ...]:
        """The light groups of light-basis passes; none without emission, or where channels are wavelengths."""
        if not self.translation.one_wavelength or not self.sources:
            return ()
        level = self.translation.rgb_level
        groups = []
        if RGB_GROUP in self.object_groups.values():
            groups.append(EmissionGroup(RGB_GROUP, rgb_illuminants() * level))
        for group, names in self.members.items():
            spectra = np.stack([self._spectra[name] if name else np.zeros(61) for name in names])
            measured = {source.lamp for source in self.sources} - {""}
            swappable = tuple(name if name in measured else "" for name in names)
            groups.append(EmissionGroup(group, spectra * level, swappable))
        return tuple(groups)

    # ------------------------------------------------------------ sockets

    def _bind(self, source: Source, name: str) -> None:
        """Send a source's colour to the channels of the pass."""
        translation, tree, socket = self.translation, source.tree, source.colour
        link = link_of(socket)
        if link is None:
            colour = self._rec709(source)
            if source.lamp and name == source.lamp:
                colour = translation.to_rec709 @ (source.filter * socket.default_value[:3])
            unlink(tree, socket)
            set_light(translation, lambda nm: set_value(socket, self._rows(name, nm) @ colour))
            return
        if not name:
            for colour in colours_upstream(link):
                translation.rec709(colour, source.owner.label, reflectance=False)
        group = self._group(name)
        if np.ptp(source.filter) > 0 or source.filter[0] != 1.0:
            product = vector_math(tree, "MULTIPLY", link.from_socket, tuple(source.filter))
            tree.links.new(product, socket)
            link = link_of(socket)
        insert_group(tree, link, socket, group)

    def _rows(self, name: str, wavelengths_nm: Array) -> Array:
        """(3, 3) from the Rec.709 colour of a source to the channels of a pass."""
        if not name:
            return rgb_rows(self.translation, rgb_illuminants(), wavelengths_nm)
        one = self.translation.one_wavelength
        channels = np.eye(3)[self.channels[name]] if one else at(wavelengths_nm, self._spectra[name])
        return np.outer(channels, LUMINANCE) / (self.translation.rgb_level if one else self.translation.level)

    def _group(self, name: str) -> bpy.types.NodeTree:
        """Node group from a colour of the working space to the channels of a pass, for one spectrum or for RGB."""
        if name not in self._groups:
            title = f"Spectral Probe Emission {name}".strip()
            self._groups[name] = light_group(
                self.translation, title, lambda nm: self._rows(name, nm), clip=not name
            )
        return self._groups[name]

    # ------------------------------------------------------------ on and off

    def shine(self, on: bool) -> None:
        """Switch all emission on or off; off, Cycles does not even sample it."""
        if on:
            for source, feeding, value in self._off:
                source.switch.default_value = value
                if feeding is not None:
                    source.tree.links.new(feeding, source.switch)
            self._off.clear()
            return
        if self._off:
            return
        for source in self.sources:
            socket = source.switch
            link = link_of(socket)
            value = socket.default_value
            self._off.append(
                (
                    source,
                    link.from_socket if link else None,
                    value if socket.type == "VALUE" else tuple(value),
                )
            )
            unlink(source.tree, socket)
            socket.default_value = 0.0 if socket.type == "VALUE" else (0.0, 0.0, 0.0)


def set_light(translation: Translation, setter: Setter) -> None:
    """Set now what light-basis passes never change; else at each pass's wavelengths."""
    if translation.one_wavelength:
        setter(np.zeros(3))
    else:
        translation.setters.append(setter)


def rgb_rows(translation: Translation, spectra: Array, wavelengths_nm: Array) -> Array:
    """(3, 3) from a Rec.709 colour to the channels of a pass, for light that is a sum of three spectra (3, 61)."""
    if translation.one_wavelength:
        return np.eye(3) / translation.rgb_level
    return np.stack([at(wavelengths_nm, spectrum) for spectrum in spectra], -1) / translation.level


def light_group(
    translation: Translation, title: str, rows_of: Callable[[Array], Array], *, clip: bool
) -> bpy.types.NodeTree:
    """Node group from a colour of the working space to the channels of a pass, by rows (3, 3) from Rec.709."""
    group, source, target = new_group(title, translation.stack)
    clip = clip and translation.wide
    colour = in_rec709(group, source, translation.to_rec709, bounded=False) if clip else source
    dots, output = dot_products(group, colour, 3)
    group.links.new(vector_math(group, "MAXIMUM", output, (0.0, 0.0, 0.0)), target)
    before = np.eye(3) if clip or not translation.wide else translation.to_rec709

    def set_rows(wavelengths_nm: Array) -> None:
        for dot, row in zip(dots, rows_of(wavelengths_nm) @ before, strict=True):
            dot.inputs[1].default_value = row

    set_light(translation, set_rows)
    return group
