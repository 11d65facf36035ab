"""Materials with a measured spectrum, as the user chose it in `Material.spectral_probe`."""

from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...preferences import library_folder
from ...spectral_probe.errors import RenderError
from ...spectral_probe.files.spectrum_csv import read_spectrum_csv
from ...spectral_probe.files.spectrum_file import is_spectrum_file
from ...spectral_probe.spectra.catalogue import curves_of, find
from ...spectral_probe.spectra.curves import NUMBER, REFLECTANCE
from ...spectral_probe.spectra.grid import WAVELENGTHS_NM
from ...spectral_probe.spectra.metals import fresnel_reflectance, refractive_index
from .shaders import measured_sockets, metal_nodes
from .translation import Translation

type Array = np.ndarray[Any, Any]

INCIDENCE_COSINES = np.cos(np.radians([0.0, 45.0, 70.0, 82.0]))
"""Incidence angles at which a metal's reflectance enters the plan."""


def metal_index(metal: str) -> tuple[Array, Array]:
    """Refractive index n, k (61,) of a metal's name, or of a CSV file wavelength_nm,n,k."""
    if metal.lower().endswith((".csv", ".txt")):
        n, k = read_spectrum_csv(Path(bpy.path.abspath(metal)), columns=2, quantity=NUMBER)
        return n, k
    n, k = refractive_index(metal, WAVELENGTHS_NM)
    return n, k


def measured_reflectance(path: str) -> Array:
    """Reflectance (61,) from a file, or of a surface of the library."""
    if not path:
        raise RenderError(
            "no file with its reflectance is given. Choose a file or a surface of the library, or another kind of spectrum."
        )
    if not is_spectrum_file(path):
        folder = library_folder()
        return curves_of(find(path, "reflectance", folder), folder)["reflectance"]
    return read_spectrum_csv(Path(bpy.path.abspath(path)), quantity=REFLECTANCE)[0]


def index_spectra(n: Array, k: Array) -> Array:
    """Reflectances (4, 61) of a metal at the incidence angles that enter the plan."""
    return fresnel_reflectance(n, k, INCIDENCE_COSINES[:, None])


def translate_metal(translation: Translation, metal: str, trees: list[bpy.types.NodeTree]) -> set[Any]:
    """Make a copy's shaders the metal; the nodes that are done."""
    n, k = metal_index(metal)
    translation.spectra.append(index_spectra(n, k))
    done = set()
    for tree, node in metal_nodes(trees):
        node.fresnel_type = "PHYSICAL_CONDUCTOR"
        translation.bind_table(tree, node.inputs["IOR"], n)
        translation.bind_table(tree, node.inputs["Extinction"], k)
        done.add(node)
    return done


def translate_reflectance(translation: Translation, path: str, trees: list[bpy.types.NodeTree]) -> set[Any]:
    """Give a copy's diffuse colours the measured reflectance; the sockets that are done."""
    reflectance = measured_reflectance(path)
    translation.spectra.append(reflectance[None])
    done = set()
    for tree, socket in measured_sockets(trees):
        translation.bind_table(tree, socket, reflectance)
        done.add(socket)
    return done
