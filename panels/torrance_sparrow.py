"""The paper's surface (eq. 12) in the material properties: a button to add it, and its parameters."""

import bpy

from .main import InProperties, settings_layout

_PARAMETERS = ("Alpha", "Beta", "Beta Mirror", "Gamma", "Diffuse Color")


class SPECTRAL_PROBE_PT_torrance_sparrow(InProperties, bpy.types.Panel):
    """A surface of diffuse reflection, a lobe of facets and a mirror."""

    bl_label = "Torrance-Sparrow"
    bl_context = "material"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be an object that carries materials."""
        return context.object is not None and hasattr(context.object.data, "materials")

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the button, and the parameters of the active material where it is such a surface."""
        self.layout.operator("spectral_probe.add_torrance_sparrow", icon="MATERIAL")
        node = _group_node(context.object.active_material)
        if node is not None:
            column = settings_layout(self.layout)
            for name in _PARAMETERS:
                column.prop(node.inputs[name], "default_value", text=name)


def _group_node(material: bpy.types.Material | None) -> bpy.types.Node | None:
    """The node of the surface's group in a material, by the inputs it has."""
    nodes = material.node_tree.nodes if material is not None and material.node_tree is not None else ()
    return next((n for n in nodes if n.type == "GROUP" and set(_PARAMETERS) <= set(n.inputs.keys())), None)
