"""Settings and results, saved in the .blend: `Scene.spectral_probe` and `Material.spectral_probe`.

Angles are radians and lengths scene units inside, as everywhere in Blender; `operators/settings.py`
converts them from and to the capture file. Paths may be relative to the .blend ("//").
"""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from .settings import capture, compare, files, job_report, outline, packed, panorama, region, swap, swatches
from .settings.backplate import SPECTRAL_PROBE_PG_backplate
from .settings.composite import SPECTRAL_PROBE_PG_composite
from .settings.known_light import FAMILIES, GROUPS, SPECTRAL_PROBE_PG_known_light
from .settings.known_light import file_path as _file
from .settings.library_pickers import ball_materials
from .settings.material import SPECTRAL_PROBE_PG_light, SPECTRAL_PROBE_PG_material
from .settings.output import SPECTRAL_PROBE_PG_output
from .settings.results import (
    SPECTRAL_PROBE_PG_comparison,
    SPECTRAL_PROBE_PG_probe,
    SPECTRAL_PROBE_PG_progress,
    SPECTRAL_PROBE_PG_render,
    folder_path,
)
from .settings.spectrum import SPECTRAL_PROBE_PG_spectrum


class SPECTRAL_PROBE_PG_scene(bpy.types.PropertyGroup):
    """Everything a scene knows about its probe, in the order of the pipeline."""

    version: IntProperty(
        name="Version",
        description="Version of these settings, by which later ones know what to make of them",
        options={"HIDDEN"},
    )
    capture_path: _file("Capture", "Capture file (TOML) that these settings were read from or saved to")
    camera: PointerProperty(type=capture.SPECTRAL_PROBE_PG_camera)
    ball_radius: FloatProperty(
        name="Radius", description="Radius of the ball", default=0.05, min=1e-4, unit="LENGTH", precision=4
    )
    ball_material: StringProperty(
        name="Material",
        description="What the ball is made of: SUS304, stainless steel, chrome, silver, aluminium, ideal; fractions of metals "
        "such as Fe 0.74, Cr 0.18, Ni 0.08; a page of refractiveindex.info; or a file with its measured reflectance (CSV)",
        default="SUS304",
        search=ball_materials,
        search_options={"SUGGESTION"},
    )
    families: EnumProperty(
        name="Lamps",
        description="Lamp families that may be present. Name only those: the fewer, the surer the spectra",
        items=FAMILIES,
        options={"ENUM_FLAG"},
        default={"incandescent", "daylight"},
    )
    families_automatic: BoolProperty(
        name="Any Lamps", description="Any lamp family may be present; let the photographs decide"
    )
    method: EnumProperty(
        name="Method",
        description="How spectra are recovered from the camera's three channels",
        items=(
            (
                "family",
                "Lamp Family",
                "Non-negative, for the lamps that may be present, seen directly or off surfaces",
            ),
            ("automatic", "Automatic", "The same for all kinds of lamps: less sure of each"),
            (
                "paper",
                "Paper",
                "Three principal components of the lamps, inverted directly (Tominaga and Tanaka)",
            ),
        ),
    )
    known_light: PointerProperty(type=SPECTRAL_PROBE_PG_known_light)
    views: CollectionProperty(type=capture.SPECTRAL_PROBE_PG_view, name="Views")
    active_view: IntProperty(name="Active View", min=0)
    all_views: BoolProperty(
        name="All Views",
        description="Look for the ball in every view, not only in the active one",
        default=True,
    )

    overlay: PointerProperty(type=outline.SPECTRAL_PROBE_PG_overlay)

    composition: EnumProperty(
        name="Composition",
        description="How several views become one panorama",
        items=(
            ("blend", "Blend", "Every direction from the views that sample it best, blended without seams"),
            (
                "cut",
                "Cut",
                "The paper's plain cut: each view to 60 degrees on both sides of the direction to its camera",
            ),
        ),
    )
    probe_width: IntProperty(
        name="Width",
        description="Width of the panorama; its height is half of it. 0: as fine as the photographs",
        default=0,
        min=0,
        soft_max=4096,
        max=16384,
        step=64,
        subtype="PIXEL",
    )
    probe_directory: folder_path(
        "Folder", "Where the files of the probe are written", "//spectral_probe/probe/"
    )
    probe: PointerProperty(type=SPECTRAL_PROBE_PG_probe)
    packed: PointerProperty(type=packed.SPECTRAL_PROBE_PG_packed)
    spectrum: PointerProperty(type=SPECTRAL_PROBE_PG_spectrum)
    region: PointerProperty(type=region.SPECTRAL_PROBE_PG_region)
    edits: PointerProperty(type=region.SPECTRAL_PROBE_PG_edits)
    swap: PointerProperty(type=swap.SPECTRAL_PROBE_PG_swap)
    planned: PointerProperty(type=swap.SPECTRAL_PROBE_PG_plan)

    light: EnumProperty(
        name="Light",
        description="What lights the spectral render, besides lamps",
        items=(
            ("PROBE", "Probe", "The panorama of the probe: its spectra were recovered from photographs"),
            (
                "WORLD",
                "Own World",
                "The scene's own world: its colours are taken as light of these colours, those of a Sky Texture as daylight",
            ),
        ),
    )
    plan: EnumProperty(
        name="Passes",
        description="How the spectrum is sampled by Cycles passes",
        items=(
            (
                "AUTOMATIC",
                "As Few as Needed",
                "As few passes as keep the error bound, chosen for the light and the materials of this scene",
            ),
            (
                "NUMBER",
                "Number",
                "Passes of light layers: this many wavelengths for every set of layers, chosen for light and materials",
            ),
            ("REFERENCE", "Reference", "All 61 wavelengths from 400 to 700 nm, three a pass: 21 passes"),
        ),
    )
    passes: IntProperty(
        name="Wavelengths",
        description="Wavelengths of every set of light layers, a pass each: all materials are set to one wavelength in a pass",
        default=5,
        min=1,
        max=21,
    )
    max_de2000: FloatProperty(
        name="Error Bound",
        description="Colour error CIEDE2000 against all 61 wavelengths that the plan may predict for 99 of 100 pixels. Where the "
        "number of wavelengths is given, it decides how many sets of light layers there are",
        default=0.5,
        min=0.01,
        soft_max=5.0,
        precision=2,
    )
    samples: IntProperty(
        name="Samples",
        description="Samples per pixel of a full pass, in place of those of the render properties",
        default=128,
        min=1,
    )
    full_samples: BoolProperty(
        name="Full Samples",
        description="Give every pass all samples, instead of its part of them or a fraction that is compared with a full pass: "
        "less noise, and nearly as many times slower as there are passes",
    )
    rgb_twin: BoolProperty(
        name="Also RGB",
        description="Render the same scene in plain RGB too, for the comparison",
        default=True,
    )
    render_directory: folder_path("Folder", "Where the render is written", "//spectral_probe/render/")
    output: PointerProperty(type=SPECTRAL_PROBE_PG_output)
    render: PointerProperty(type=SPECTRAL_PROBE_PG_render)
    composite: PointerProperty(type=SPECTRAL_PROBE_PG_composite)
    comparison_blur_px: FloatProperty(
        name="Blur",
        description="Gaussian blur of both images before they are compared, in pixels: takes the noise out",
        min=0.0,
        soft_max=10.0,
        precision=1,
        subtype="PIXEL",
    )
    compare: PointerProperty(type=compare.SPECTRAL_PROBE_PG_compare)
    comparison: PointerProperty(type=SPECTRAL_PROBE_PG_comparison)
    backplate: PointerProperty(type=SPECTRAL_PROBE_PG_backplate)
    swatches: PointerProperty(type=swatches.SPECTRAL_PROBE_PG_swatch_light)


_register_classes, _unregister_classes = bpy.utils.register_classes_factory(
    (
        *GROUPS,
        *outline.CLASSES,
        *capture.CLASSES,
        SPECTRAL_PROBE_PG_probe,
        *packed.CLASSES,
        SPECTRAL_PROBE_PG_output,
        SPECTRAL_PROBE_PG_render,
        SPECTRAL_PROBE_PG_composite,
        SPECTRAL_PROBE_PG_comparison,
        SPECTRAL_PROBE_PG_spectrum,
        *region.CLASSES,
        *swap.CLASSES,
        SPECTRAL_PROBE_PG_backplate,
        *compare.CLASSES,
        *swatches.CLASSES,
        SPECTRAL_PROBE_PG_scene,
        SPECTRAL_PROBE_PG_material,
        SPECTRAL_PROBE_PG_light,
        SPECTRAL_PROBE_PG_progress,
        *job_report.CLASSES,
    )
)


def register() -> None:
    """Attach the settings to scenes and materials."""
    _register_classes()
    bpy.types.Scene.spectral_probe = PointerProperty(type=SPECTRAL_PROBE_PG_scene, name="Spectral Probe")
    bpy.types.Material.spectral_probe = PointerProperty(
        type=SPECTRAL_PROBE_PG_material, name="Spectral Probe"
    )
    bpy.types.Light.spectral_probe = PointerProperty(type=SPECTRAL_PROBE_PG_light, name="Spectral Probe")
    bpy.types.WindowManager.spectral_probe = PointerProperty(
        type=SPECTRAL_PROBE_PG_progress, options={"SKIP_SAVE"}
    )
    job_report.attach()
    swatches.register()
    panorama.register()
    files.register()


def unregister() -> None:
    """Detach them."""
    files.unregister()
    panorama.unregister()
    swatches.unregister()
    job_report.detach()
    del bpy.types.WindowManager.spectral_probe
    del bpy.types.Light.spectral_probe
    del bpy.types.Material.spectral_probe
    del bpy.types.Scene.spectral_probe
    _unregister_classes()
