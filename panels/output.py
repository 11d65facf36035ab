"""What a spectral render writes: drawn within the panel of the render."""

import bpy


def draw_output(column: bpy.types.UILayout, output: bpy.types.AnyType) -> None:
    """The settings of the outputs, `Scene.spectral_probe.output`."""
    column.prop(output, "spectral")
    column.prop(output, "denoise")
    column.prop(output, "adapt")
    if output.adapt:
        column.prop(output, "white")
