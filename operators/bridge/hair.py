"""Principled Hair by melanin: the absorption of the pigments over wavelength in place of the node's three numbers."""

from typing import Any

import bpy
import numpy as np

from ...spectral_probe.spectra.grid import WAVELENGTHS_NM
from .shaders import link_of
from .translation import RGB_INDEX_NM, Translation

type Array = np.ndarray[Any, Any]

EUMELANIN = (0.506, 0.841, 1.653)
PHEOMELANIN = (0.343, 0.733, 1.924)
"""Absorption of the pigments for red, green and blue as in Cycles (d'Eon et al. 2011, doi:10.1111/j.1467-8659.2011.01976.x)."""


def pigment(absorption: tuple[float, float, float]) -> Array:
    """Absorption (61,) of a pigment: the power law of wavelength through its three numbers (least squares of logarithms).

    Melanin's absorption is a power of wavelength in the visible (Jacques 2013, doi:10.1088/0031-9155/58/11/R37).
    """
    slope, intercept = np.polyfit(np.log(RGB_INDEX_NM), np.log(absorption), 1)
    return np.asarray(np.exp(intercept + slope * np.log(WAVELENGTHS_NM)))


def translate_melanin(
    translation: Translation, label: str, tree: bpy.types.NodeTree, node: bpy.types.Node
) -> bool:
    """Let a Principled Hair's melanin absorb by wavelength; False where the node has none."""
    if node.parametrization != "MELANIN":
        return False
    names = ("Melanin", "Melanin Redness", "Random Color", "Tint")
    if any(link_of(node.inputs[name]) for name in names) or node.inputs["Random Color"].default_value > 0:
        translation.warnings.append(
            f"{label} has hair whose melanin varies; the mean of it was taken for all hairs. Use the hair's colour in place of "
            "melanin for variation."
        )
    melanin, redness = (float(node.inputs[name].default_value) for name in names[:2])
    amount = -np.log(max(1.0 - melanin, 1e-4))
    absorption = amount * ((1.0 - redness) * pigment(EUMELANIN) + redness * pigment(PHEOMELANIN))
    if min(node.inputs["Tint"].default_value[:3]) < 1.0:
        translation.warnings.append(
            f"{label} has hair with a tint over its melanin; it was left out. Use the hair's colour."
        )
    node.parametrization = "ABSORPTION"
    translation.bind_table(tree, node.inputs["Absorption Coefficient"], absorption)
    return True
