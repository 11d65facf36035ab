"""The ball's outline over its photograph: what is drawn, and what is kept of each view to draw it."""

import bpy
from bpy.props import (
    BoolProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    IntVectorProperty,
    PointerProperty,
    StringProperty,
)


class SPECTRAL_PROBE_PG_shown_view(bpy.types.PropertyGroup):
    """A photograph of a view as a picture, and what an outline fitted to it left."""

    picture: PointerProperty(
        name="Picture", description="The photograph, developed for the screen", type=bpy.types.Image
    )
    photo: IntProperty(name="Photograph", description="Which photograph of the view is shown", min=0)
    size_px: IntVectorProperty(
        name="Size",
        description="Width and height of the photograph in pixels, whatever the size of the picture",
        size=2,
        min=0,
    )
    summary: StringProperty(
        name="Residuals and Zones",
        description="What the outline's fit left at each degree of the rim, and how well the ball shows what is where",
    )
    cone_angle: FloatProperty(
        name="Blind Cone",
        description="Half angle of the directions behind the ball that this view does not see. 0: not known",
        subtype="ANGLE",
    )
    fitted_px: FloatVectorProperty(
        name="Fitted From", description="The circle that the outline was fitted near", size=3, precision=2
    )


class SPECTRAL_PROBE_PG_overlay(bpy.types.PropertyGroup):
    """What is drawn over a photograph in the Image Editor."""

    show: BoolProperty(
        name="Overlay", description="Draw the ball's outline over its photograph", default=True
    )
    show_residuals: BoolProperty(
        name="Residuals",
        description="Show how far the edge lies from the outline, all round the rim",
        default=True,
    )
    residual_scale: FloatProperty(
        name="Times",
        description="How much longer than they are the residuals are drawn",
        default=20.0,
        min=1.0,
        soft_max=100.0,
        precision=0,
    )
    show_zones: BoolProperty(
        name="Confidence",
        description="Tint where the ball shows little: towards the rim a pixel spans ever more directions, and in the middle "
        "the camera sees itself",
        default=True,
    )
    show_handles: BoolProperty(
        name="Handles", description="Move the outline with the mouse: its centre, and its rim", default=True
    )
    snap: BoolProperty(
        name="Snap to Rim",
        description="While the outline is dragged, fit it to the edge of the ball that lies near it",
        default=True,
    )
    exposure_ev: FloatProperty(
        name="Brightness",
        description="Brighter or darker by so many stops, when a photograph is shown",
        soft_min=-6.0,
        soft_max=6.0,
        precision=1,
    )


CLASSES = (SPECTRAL_PROBE_PG_shown_view, SPECTRAL_PROBE_PG_overlay)
