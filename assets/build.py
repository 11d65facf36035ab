"""Build the asset library: spectral metals, glasses and measured surfaces, with previews, as one .blend and its catalogue.

    .venv/bin/python assets/build.py [FOLDER]

What the library knows by name becomes an asset each; the same list is read by the tests. The .blend names entries of the library
and has their look under D65; the measurements themselves stay with the extension.
"""

from __future__ import annotations

import importlib
import sys
import tempfile
import uuid
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import numpy as np

BLEND = "spectral_materials.blend"
CATALOGUE = "blender_assets.cats.txt"
AUTHOR = "The Spectral Probe authors"
BODY_THICKNESS_M = 0.05
PREVIEW_PX, PREVIEW_SAMPLES = 128, 20

_NAMESPACE = uuid.UUID(
    "6f0a5c1e-6d0b-5b7e-9b7c-2f6f3f1f8a51"
)  # names of catalogues keep their identity between builds
_ROUGHNESS = {
    "Hg": 0.0,
    "Cr": 0.06,
    "Fe": 0.25,
    "Ti": 0.25,
    "TiN": 0.12,
    "Zn": 0.3,
    "W": 0.25,
    "stainless steel": 0.2,
}
_CHART = "ColorChecker N Ohta"
_BODIES = {"water": "Water", "diamond": "Diamond", "sapphire": "Sapphire", "fused silica": "Fused Silica"}


@dataclass(frozen=True)
class Asset:
    """One asset: its name, its catalogue, and the spectral settings of its material, by property."""

    name: str
    catalogue: str
    settings: dict[str, Any]
    tags: tuple[str, ...]
    about: str
    licence: str
    roughness: float = 0.0

    @property
    def catalogue_id(self) -> str:
        """The catalogue's identity, the same in every build."""
        return identity(self.catalogue)


def wanted(core: Any) -> Iterator[Asset]:
    """The assets, from what the core's library knows: `core` imports a module of it."""
    catalogue, metals = core("spectra.catalogue").catalogue, core("spectra.metals")
    for entry in catalogue("metal"):
        english = metals.METAL_NAMES[entry.name]
        tags = ("metal", entry.name.lower(), *english.lower().split())
        about = f"Complex refractive index of {english.lower()}: {entry.source}"
        settings = {"kind": "METAL", "metal": entry.name}
        yield Asset(english, "Metals", settings, tags, about, entry.licence, _ROUGHNESS.get(entry.name, 0.1))
    short = core("spectra.glass").SHORT_NAMES
    for entry in catalogue("glass"):
        if entry.name not in short:
            yield from _stained(entry)
    clear, page_of = core("spectra.dispersion").CLEAR_PAGES, core("spectra.refractive").page_of
    for name, page in clear.items():
        about = f"Clear, refracts each wavelength differently: {page_of(page).reference}"
        settings = {"kind": "DISPERSIVE", "clear_material": name}
        label = _BODIES.get(name, f"{name} Glass")
        yield Asset(
            label, "Clear Glass", settings, ("glass", "clear", "dispersion", *name.lower().split()), about,
            "CC0 1.0 (refractiveindex.info)",
        )  # fmt: skip
    for entry in catalogue("reflectance"):
        if entry.family == _CHART:
            patch = entry.name.partition(": ")[2]
            settings = {"kind": "REFLECTANCE", "reflectance_path": entry.name}
            about = f"Measured reflectance, patch of the ColorChecker: {entry.source}"
            yield Asset(
                f"ColorChecker {patch.title()}", "ColorChecker", settings, ("reflectance", "chart", *patch.split()),
                about, entry.licence,
            )  # fmt: skip


def _stained(entry: Any) -> Iterator[Asset]:
    label = f"{entry.name.replace('-', ' ').title()} Glass"
    tags = ("glass", "stained", *entry.name.split("-"))
    thick = f"As a closed body it is as dark as the pane after {100 * BODY_THICKNESS_M:g} cm: set Thickness for larger things. "
    for form, about, settings in (
        ("Pane", "Thin filter: for a pane that is a single surface. ", {"glass_as": "FILTER"}),
        ("Body", thick, {"glass_as": "BODY", "glass_thickness": BODY_THICKNESS_M}),
    ):
        yield Asset(
            f"{label} {form}", f"Stained Glass/{form}", {"kind": "GLASS", "glass": entry.name, **settings},
            (*tags, form.lower()), about + f"Transmittance: {entry.source}", entry.licence,
        )  # fmt: skip


def main(folder: Path) -> None:
    """Write the .blend and the catalogue."""
    with tempfile.TemporaryDirectory() as temporary:
        extension = enabled(Path(temporary))
        look = importlib.import_module(f"{extension}.operators.bridge.look")
        assets = list(wanted(lambda name: importlib.import_module(f"{extension}.spectral_probe.{name}")))
        scene, ball = preview_scene()
        for asset in assets:
            material = material_of(asset, look)
            ball.data.materials.clear()
            ball.data.materials.append(material)
            preview(scene, material, Path(temporary) / "preview.png")
            sys.stderr.write(f"{asset.name}\n")
        ball.data.materials.clear()
        made = {bpy.data.materials[asset.name] for asset in assets}
        bpy.data.libraries.write(str(folder / BLEND), made, fake_user=True, compress=True)
    (folder / CATALOGUE).write_text(catalogue_text(assets), encoding="utf-8")


def catalogue_text(assets: list[Asset]) -> str:
    """The file of catalogues, parents among them: those that Blender has to make up show as unsaved."""
    paths = {asset.catalogue for asset in assets}
    paths |= {path.partition("/")[0] for path in paths}
    lines = [f"{identity(path)}:{path}:{path.replace('/', '-')}" for path in sorted(paths)]
    return "\n".join(["# Catalogues of the assets, written by build.py", "", "VERSION 1", "", *lines, ""])


def identity(catalogue: str) -> str:
    """A catalogue's identity, the same in every build."""
    return str(uuid.uuid5(_NAMESPACE, catalogue))


def enabled(folder: Path) -> str:
    """Enable the extension of this checkout from an empty user folder; the name of its package."""
    import addon_utils

    repository = folder / "extensions"
    repository.mkdir()
    (repository / "spectral_probe").symlink_to(Path(__file__).resolve().parents[1], target_is_directory=True)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.preferences.extensions.repos.new(
        name="build", module="build", custom_directory=str(repository), source="USER"
    )
    package = "bl_ext.build.spectral_probe"

    def fail(problem: Exception) -> None:
        raise problem

    addon_utils.enable(package, handle_error=fail)
    return package


def material_of(asset: Asset, look: ModuleType) -> Any:
    """The asset's material: its spectral settings, the shader that fits them, and its passport."""
    material = bpy.data.materials.new(asset.name)
    tree = material.node_tree
    tree.nodes.clear()
    tree.nodes.new("ShaderNodeOutputMaterial").location = (300.0, 300.0)
    for name, value in asset.settings.items():
        setattr(material.spectral_probe, name, value)
    look.material_look(material)
    for node in tree.nodes:
        if "Roughness" in node.inputs:
            node.inputs["Roughness"].default_value = asset.roughness
    material.roughness = asset.roughness
    material.asset_mark()
    about = material.asset_data
    about.author, about.description, about.license = (
        AUTHOR,
        asset.about,
        f"GPL-3.0-or-later; data: {asset.licence}",
    )
    about.catalog_id = asset.catalogue_id
    about.use_preferred_import_method, about.preferred_import_method = True, "APPEND"
    for tag in dict.fromkeys(("spectral", *asset.tags)):
        about.tags.new(tag, skip_if_exists=True)
    return material


def preview_scene() -> tuple[Any, Any]:
    """A ball on a chequered ground under two lamps and a grey sky; the ball."""
    scene = bpy.context.scene
    scene.render.engine, scene.render.resolution_x, scene.render.resolution_y = (
        "CYCLES",
        PREVIEW_PX,
        PREVIEW_PX,
    )
    scene.cycles.samples, scene.cycles.seed, scene.cycles.use_adaptive_sampling = PREVIEW_SAMPLES, 1, False
    scene.cycles.use_denoising, scene.cycles.denoiser = True, "OPENIMAGEDENOISE"
    scene.cycles.max_bounces = scene.cycles.transmission_bounces = 6
    scene.render.use_persistent_data = True
    scene.view_settings.view_transform, scene.render.film_transparent = "Standard", False
    scene.render.image_settings.file_format, scene.render.image_settings.color_mode = "PNG", "RGBA"
    scene.world = bpy.data.worlds.new("Sky")
    background = next(node for node in scene.world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Color"].default_value = (0.32, 0.32, 0.32, 1.0)
    bpy.ops.mesh.primitive_plane_add(size=12.0)
    bpy.context.object.data.materials.append(_chequered())
    for location, size, watts in (((-2.2, -1.6, 3.0), 1.6, 130.0), ((2.6, -0.6, 1.6), 1.0, 40.0)):
        bpy.ops.object.light_add(type="AREA", location=location)
        lamp = bpy.context.object
        lamp.data.size, lamp.data.energy = size, watts
        lamp.rotation_euler = (-lamp.location).to_track_quat("-Z", "Y").to_euler()
    bpy.ops.object.camera_add(location=(0.0, -4.4, 1.7))
    camera = scene.camera = bpy.context.object
    camera.data.lens = 62.0
    camera.rotation_euler = (
        (bpy.data.objects["Plane"].location - camera.location).to_track_quat("-Z", "Y").to_euler()
    )
    camera.rotation_euler.x += 0.185
    bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48, radius=0.9, location=(0.0, 0.0, 0.9))
    bpy.ops.object.shade_smooth()
    return scene, bpy.context.object


def _chequered() -> Any:
    material = bpy.data.materials.new("Ground")
    tree = material.node_tree
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Roughness"].default_value = 0.9
    checker = tree.nodes.new("ShaderNodeTexChecker")
    checker.inputs["Scale"].default_value = 24.0
    checker.inputs["Color1"].default_value, checker.inputs["Color2"].default_value = (
        (0.5, 0.5, 0.5, 1),
        (0.2, 0.2, 0.2, 1),
    )
    tree.links.new(checker.outputs["Color"], shader.inputs["Base Color"])
    return material


def preview(scene: Any, material: Any, path: Path) -> None:
    """Render the scene and keep the picture as the material's preview."""
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path), check_existing=False)
    image.colorspace_settings.name = "Non-Color"
    pixels = np.empty(PREVIEW_PX * PREVIEW_PX * 4, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    shown = material.preview_ensure()
    shown.image_size = (PREVIEW_PX, PREVIEW_PX)
    shown.image_pixels.foreach_set(np.rint(pixels * 255).astype(np.uint8).view(np.int32))


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent).resolve())
