"""What materials and lamps are in spectral renders, in their properties."""

import bpy

from .main import InProperties, settings_layout


def draw_spectrum(column: bpy.types.UILayout, material: bpy.types.Material) -> None:
    """The spectral settings of a material's surface: the kind, and what matters for it."""
    settings = material.spectral_probe
    column.prop(settings, "kind")
    match settings.kind:
        case "METAL":
            column.prop(settings, "metal")
        case "REFLECTANCE":
            column.prop(settings, "reflectance_path", text="Surface")
        case "GLASS":
            column.prop(settings, "glass")
            column.prop(settings, "glass_as")
            if settings.glass_as == "BODY":
                column.prop(settings, "glass_thickness")
                column.prop(settings, "glass_with_surfaces")
        case "DISPERSIVE":
            column.prop(settings, "index_from", text="Index")
            if settings.index_from == "PAGE":
                column.prop(settings, "clear_material")
            elif settings.index_from == "CAUCHY":
                for index, name in enumerate("ABC"):
                    column.prop(settings, "cauchy", index=index, text=name)
            else:
                column.prop(settings, "sellmeier_b")
                column.prop(settings, "sellmeier_c")


def draw_light(column: bpy.types.UILayout, settings: bpy.types.PropertyGroup, text: str = "Light") -> None:
    """The spectrum of a lamp or of what a material emits."""
    column.prop(settings, "light", text=text)
    if settings.light == "LAMP":
        column.prop(settings, "lamp")


class SPECTRAL_PROBE_PT_material(InProperties, bpy.types.Panel):
    """Spectral settings of the active material."""

    bl_label = "Spectral Probe"
    bl_context = "material"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a material."""
        return context.material is not None

    def draw(self, context: bpy.types.Context) -> None:
        """Draw its settings."""
        column = settings_layout(self.layout)
        draw_spectrum(column, context.material)
        draw_light(column, context.material.spectral_probe, "Emission")


class SPECTRAL_PROBE_PT_light(InProperties, bpy.types.Panel):
    """Spectral settings of the active lamp."""

    bl_label = "Spectral Probe"
    bl_context = "data"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a lamp."""
        return context.light is not None

    def draw(self, context: bpy.types.Context) -> None:
        """Draw its settings."""
        draw_light(settings_layout(self.layout), context.light.spectral_probe)
