"""What a grey shader at one wavelength cannot be made of: switched off or left as it is, and named."""

import bpy

from .shaders import link_of, unlink
from .translation import Translation


def name_untranslated(
    translation: Translation, label: str, tree: bpy.types.NodeTree, node: bpy.types.Node
) -> None:
    """Take out of a shader what would put red, green and blue on the layers of light, and say so."""
    warnings = translation.warnings
    if node.type == "SCRIPT":
        warnings.append(
            f"{label} has a script node; colours inside the script stay RGB. Use Cycles' own nodes instead."
        )
    film = node.inputs.get("Thin Film Thickness")
    if film is not None and (link_of(film) is not None or film.default_value > 0):
        unlink(tree, film)
        film.default_value = 0.0
        warnings.append(
            f"{label} has a thin film, whose colours Cycles computes for red, green and blue only; it was left out. "
            "Set its thickness to 0 for equal renders in RGB."
        )
    if node.type == "PRINCIPLED_VOLUME":
        _volume(translation, label, tree, node)


def _volume(translation: Translation, label: str, tree: bpy.types.NodeTree, node: bpy.types.Node) -> None:
    """A Principled Volume's own colour grid and fire, which no node can be put behind."""
    colours = node.inputs["Color Attribute"]
    if colours.default_value:
        colours.default_value = ""
        translation.warnings.append(
            f"{label} takes its volume's colour from a grid of that name, which stays RGB and was left out. Link an Attribute "
            "node to Color instead."
        )
    fire = node.inputs["Blackbody Intensity"]
    if link_of(fire) is not None or fire.default_value > 0:
        unlink(tree, fire)
        fire.default_value = 0.0
        translation.warnings.append(
            f"{label} has a volume that glows by its temperature inside the shader, which was left out. Link a Blackbody node to "
            "Emission Color instead."
        )
