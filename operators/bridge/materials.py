"""Materials for one wavelength after another, on temporary copies: the user's node trees are never edited.

What a material becomes is chosen by `Material.spectral_probe`:

- **METAL**: Metallic, Glossy and Principled shaders become the Metallic BSDF with the metal's complex refractive index
  (exact Fresnel in each channel); roughness, distribution and normal stay.
- **REFLECTANCE**: the colour of Diffuse, Principled, Subsurface and Translucent shaders becomes the measured reflectance.
- **RGB** (the default), and all other shaders of the two above: every colour is uplifted to a reflectance by Mallett & Yuksel
  (2019), textures and other linked colours by three dot products behind the link.

Light that materials emit is not spectral yet: it is switched off, and named in the warnings.
"""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Color

from ...preferences import library_folder
from ...spectral_probe.errors import RenderError, SpectralProbeError
from ...spectral_probe.files.spectrum_csv import read_spectrum_csv
from ...spectral_probe.files.spectrum_file import is_spectrum_file
from ...spectral_probe.spectra.catalogue import curves_of, find
from ...spectral_probe.spectra.colorimetry import illuminant, spectra_to_xyz, xyz_to_rec709
from ...spectral_probe.spectra.curves import NUMBER, REFLECTANCE
from ...spectral_probe.spectra.grid import WAVELENGTHS_NM
from ...spectral_probe.spectra.metals import fresnel_reflectance, refractive_index
from ...spectral_probe.spectra.uplift import reflectance_basis
from .restore import in_scene, refuse_linked, stand_in
from .shaders import darken, link_of, measured_sockets, metal_nodes, own_trees, set_value, shaders, unlink

COLOUR_VECTORS = (
    "Radius",
    "Subsurface Radius",
    "Absorption Coefficient",
    "Absorption Coefficients",
    "Scatter Coefficients",
)

RGB_INDEX_NM = (611.0, 549.0, 464.0)
"""Dominant wavelengths of the Rec.709 primaries: where a refractive index given per channel is taken to hold."""

INCIDENCE_COSINES = np.cos(np.radians([0.0, 45.0, 70.0, 82.0]))
"""Incidence angles at which a metal's reflectance enters the plan."""

type Array = np.ndarray[Any, Any]
type RowsOf = Callable[[Array], Array]


@dataclass
class SpectralMaterials:
    """The scene's materials, ready to be set to wavelengths.

    `spectra` (N, 61) are the reflectances that occur, for the plan; `warnings` name what was not translated.
    """

    setters: list[Callable[[Array], None]] = field(default_factory=list)
    spectra: list[Array] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)

    def set_wavelengths(self, wavelengths_nm: Array) -> None:
        """Set channel c of every material to ``wavelengths_nm[c]``."""
        for setter in self.setters:
            setter(np.asarray(wavelengths_nm, float))


def working_to_rec709() -> Array:
    """(3, 3) matrix from the file's working colour space to linear Rec.709."""
    return np.array([Color(unit).from_scene_linear_to_rec709_linear() for unit in np.eye(3)], float).T


@contextmanager
def spectral_materials(scene: bpy.types.Scene, *, one_wavelength: bool) -> Iterator[SpectralMaterials]:
    """Stand-ins for all materials of the scene that can be set to wavelengths.

    Parameters
    ----------
    scene
        The scene to be rendered.
    one_wavelength
        All three channels will always have the same wavelength; textures then need one dot product, not three.
    """
    materials = SpectralMaterials()
    with _stand_ins(scene) as copies:
        for name, copy, trees in copies:
            with _naming(name):
                _Spectral(materials, one_wavelength).translate(name, copy, trees)
        yield materials


@contextmanager
def rgb_materials(scene: bpy.types.Scene) -> Iterator[None]:
    """Stand-ins as an artist would make them for plain RGB rendering.

    A metal is the Metallic BSDF's F82 model with the base colour and the edge tint that the metal shows under D65, a
    measured reflectance its colour under D65; other colours stay. Emission is off, as in the spectral passes.
    """
    with _stand_ins(scene) as copies:
        for name, copy, trees in copies:
            with _naming(name):
                _ordinary(copy, trees)
        yield


@contextmanager
def _naming(material: str) -> Iterator[None]:
    """Say in an error message which material it is about."""
    try:
        yield
    except SpectralProbeError as error:
        raise RenderError(f'Material "{material}": {error}') from error


type _Copy = tuple[str, bpy.types.Material, list[bpy.types.NodeTree]]


@contextmanager
def _stand_ins(scene: bpy.types.Scene) -> Iterator[list[_Copy]]:
    """A stand-in for each material of the scene: (the original's name, the copy, its node trees with all groups)."""
    originals = in_scene(scene, [m for m in bpy.data.materials if not m.is_grease_pencil])
    copies: list[_Copy] = []
    with ExitStack() as stack:
        for original in originals:
            copy = original.copy()
            stack.enter_context(stand_in(original, copy))
            copy.animation_data_clear()
            trees = own_trees(copy.node_tree, stack) if copy.node_tree else []
            copies.append((original.name, copy, trees))
        refuse_linked(scene, originals, "Material")
        yield copies


def _settings(material: bpy.types.Material) -> tuple[str, str, str]:
    """Kind, metal and path of the reflectance; a plain RGB material where the extension is not registered."""
    settings = getattr(material, "spectral_probe", None)
    if settings is None:
        return "RGB", "", ""
    return settings.kind, settings.metal, settings.reflectance_path


def _index(metal: str) -> tuple[Array, Array]:
    """Refractive index n, k (61,) of a metal's name, or of a CSV file wavelength_nm,n,k."""
    if metal.lower().endswith((".csv", ".txt")):
        n, k = read_spectrum_csv(Path(bpy.path.abspath(metal)), columns=2, quantity=NUMBER)
        return n, k
    n, k = refractive_index(metal, WAVELENGTHS_NM)
    return n, k


def _reflectance(path: str) -> Array:
    """Reflectance (61,) from a file, or of a surface of the library."""
    if not path:
        raise RenderError(
            "no file with its reflectance is given. Choose a file or a surface of the library, or another kind of spectrum."
        )
    if not is_spectrum_file(path):
        folder = library_folder()
        return curves_of(find(path, "reflectance", folder), folder)["reflectance"]
    return read_spectrum_csv(Path(bpy.path.abspath(path)), quantity=REFLECTANCE)[0]


def _at(wavelengths_nm: Array, values: Array) -> Array:
    return np.interp(wavelengths_nm, WAVELENGTHS_NM, values)


class _Spectral:
    """Translates one material's copy, and collects what has to be set at each wavelength."""

    def __init__(self, materials: SpectralMaterials, one_wavelength: bool) -> None:
        self.materials = materials
        self.one_wavelength = one_wavelength
        basis, to_rec709 = reflectance_basis(), working_to_rec709()
        self.reflectance_rows = lambda nm: np.stack([_at(nm, primary) for primary in basis.T], -1) @ to_rec709
        self.basis_spectra = basis.T

    def translate(self, name: str, copy: bpy.types.Material, trees: list[bpy.types.NodeTree]) -> None:
        """Prepare a material's copy for wavelengths."""
        kind, metal, path = _settings(copy)
        if not trees:
            self.materials.warnings.append(f'Material "{name}" has no nodes; its viewport colour stays RGB.')
            return
        done: set[bpy.types.NodeSocket] = set()
        if kind == "METAL":
            n, k = _index(metal)
            self.materials.spectra.append(fresnel_reflectance(n, k, INCIDENCE_COSINES[:, None]))
            for tree, node in metal_nodes(trees):
                node.fresnel_type = "PHYSICAL_CONDUCTOR"
                for socket, values in ((node.inputs["IOR"], n), (node.inputs["Extinction"], k)):
                    self._bind_table(tree, socket, values)
                done.add(node)
        elif kind == "REFLECTANCE":
            reflectance = _reflectance(path)
            self.materials.spectra.append(reflectance[None])
            for tree, socket in measured_sockets(trees):
                self._bind_table(tree, socket, reflectance)
                done.add(socket)
        emits = False
        for tree, node in shaders(trees):
            emits |= darken(tree, node)
            if node not in done:
                self._uplift(name, tree, node, done)
        if emits:
            self.materials.warnings.append(
                f'Material "{name}" emits light. Emission is not spectral yet and was left out, of the RGB render too.'
            )

    def _bind_table(self, tree: bpy.types.NodeTree, socket: bpy.types.NodeSocket, values: Array) -> None:
        unlink(tree, socket)
        self.materials.setters.append(lambda nm: set_value(socket, _at(nm, values)))

    def _uplift(self, name: str, tree: bpy.types.NodeTree, node: bpy.types.Node, done: set[Any]) -> None:
        """Every colour of a shader node from the working space to reflectance."""
        warnings = self.materials.warnings
        if node.type == "SCRIPT":
            warnings.append(f'Material "{name}" has a script node; colours inside the script stay RGB.')
        conductor = node.type == "BSDF_METALLIC" and node.fresnel_type == "PHYSICAL_CONDUCTOR"
        if conductor:
            warnings.append(
                f'Material "{name}" has a refractive index of three channels only; it was interpolated between 464, 549 '
                "and 611 nm. Choose a metal in the material's Spectral Probe panel for measured ones."
            )
            for socket in (node.inputs["IOR"], node.inputs["Extinction"]):
                self._bind(tree, socket, _rgb_index_rows)
            n, k = (
                np.asarray(node.inputs[s].default_value) @ _rgb_index_rows(WAVELENGTHS_NM).T
                for s in ("IOR", "Extinction")
            )
            self.materials.spectra.append(fresnel_reflectance(n, k, INCIDENCE_COSINES[:, None]))
            return
        for socket in node.inputs:
            colour = socket.type == "RGBA" or (socket.type == "VECTOR" and socket.name in COLOUR_VECTORS)
            if not colour or socket in done or socket.name.startswith("Emission"):
                continue
            if socket.type == "RGBA" and socket.enabled:
                self._note_spectra(socket)
            self._bind(tree, socket, self.reflectance_rows)

    def _note_spectra(self, socket: bpy.types.NodeSocket) -> None:
        if link_of(socket):
            self.materials.spectra.append(self.basis_spectra)
        else:
            colour = np.asarray(socket.default_value[:3])
            spectrum = np.clip(self.reflectance_rows(WAVELENGTHS_NM) @ colour, 0.0, 1.0)
            if np.ptp(spectrum) > 1e-3:
                self.materials.spectra.append(spectrum[None])

    def _bind(self, tree: bpy.types.NodeTree, socket: bpy.types.NodeSocket, rows_of: RowsOf) -> None:
        """Send a socket's colour through rows (3, 3) of the wavelengths: a constant here, a link by dot products."""
        link = link_of(socket)
        if link is None:
            constant = np.asarray(socket.default_value[:3], float)
            unlink(tree, socket)
            self.materials.setters.append(
                lambda nm: set_value(socket, np.maximum(rows_of(nm) @ constant, 0.0))
            )
            return
        source = link.from_socket
        dots = [tree.nodes.new("ShaderNodeVectorMath") for _ in range(1 if self.one_wavelength else 3)]
        for dot in dots:
            dot.operation = "DOT_PRODUCT"
            tree.links.new(source, dot.inputs[0])
        if self.one_wavelength:
            tree.links.new(dots[0].outputs["Value"], socket)
        else:
            joined = tree.nodes.new("ShaderNodeCombineXYZ")
            for dot, channel in zip(dots, joined.inputs, strict=True):
                tree.links.new(dot.outputs["Value"], channel)
            tree.links.new(joined.outputs[0], socket)

        def set_rows(wavelengths_nm: Array) -> None:
            for dot, row in zip(dots, rows_of(wavelengths_nm), strict=False):
                dot.inputs[1].default_value = tuple(map(float, row))

        self.materials.setters.append(set_rows)


def _rgb_index_rows(wavelengths_nm: Array) -> Array:
    """(..., 3) weights of red, green and blue by which a refractive index of three channels is interpolated."""
    red, green, blue = RGB_INDEX_NM
    return np.stack(
        [
            np.interp(wavelengths_nm, (green, red), (0.0, 1.0)),
            np.interp(wavelengths_nm, (blue, green, red), (0.0, 1.0, 0.0)),
            np.interp(wavelengths_nm, (blue, green), (1.0, 0.0)),
        ],
        -1,
    )


def _under_d65(reflectance: Array) -> Array:
    """Colour (..., 3) of reflectances (..., 61) under D65 in the working space, white being 1."""
    light = illuminant("D65")
    xyz = spectra_to_xyz(reflectance * light) / spectra_to_xyz(light)[1]
    rec709 = xyz_to_rec709(xyz)
    return rec709 @ np.linalg.inv(working_to_rec709()).T


def metal_colours(metal: str) -> tuple[Array, Array]:
    """Base colour and edge tint (3,) of a metal for the Metallic BSDF's F82 model, in the working space, under D65.

    The F82 model (Kutz, Hasan & Edmondson 2021) is Schlick's approximation times the tint at cos = 1/7.
    """
    n, k = _index(metal)
    facing, edge = (_under_d65(fresnel_reflectance(n, k, np.array(cosine))) for cosine in (1.0, 1.0 / 7.0))
    schlick = facing + (1.0 - facing) * (6.0 / 7.0) ** 5
    return np.clip(facing, 0.0, 1.0), np.clip(edge / schlick, 0.0, 1.0)


def _ordinary(copy: bpy.types.Material, trees: list[bpy.types.NodeTree]) -> None:
    """Make a material's copy the RGB twin of its spectral one."""
    kind, metal, path = _settings(copy)
    if not trees:
        return
    if kind == "METAL":
        facing, tint = metal_colours(metal)
        for tree, node in metal_nodes(trees):
            node.fresnel_type = "F82"
            for socket, colour in ((node.inputs["Base Color"], facing), (node.inputs["Edge Tint"], tint)):
                unlink(tree, socket)
                set_value(socket, colour)
    elif kind == "REFLECTANCE":
        colour = np.maximum(_under_d65(_reflectance(path)), 0.0)
        for tree, socket in measured_sockets(trees):
            unlink(tree, socket)
            set_value(socket, colour)
    for tree, node in shaders(trees):
        darken(tree, node)
