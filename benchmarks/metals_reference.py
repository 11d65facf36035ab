"""Gold, silver and copper balls against an independent spectral renderer.

Renders `scene.json` of a reference folder by the 61-wavelength plan and by light-basis plans, and compares the XYZ images with
`reference_xyz.npz` and with each other. Usage, from the repository:

    .venv/bin/python benchmarks/metals_reference.py FOLDER [-o out/] [--samples 64] [--passes 4 5 7]

Colour differences are taken after a Gaussian blur of sigma 3 pixels on both images; the white is D65 with Y = 1 at the
reference's 95th percentile, and values are clipped at 3.
"""

import argparse
import importlib
import importlib.util
import json
import math
import sys
from pathlib import Path
from typing import Any

import bpy
import cv2
import numpy as np
from mathutils import Vector

ROOT = Path(__file__).resolve().parents[1]
EXTENSION = "spectral_probe_extension"
PANORAMA_HEIGHT = 1024

type Array = np.ndarray[Any, Any]


def load_extension() -> None:
    """Load the checkout as a package and attach its settings to Blender's materials."""
    spec = importlib.util.spec_from_file_location(
        EXTENSION, ROOT / "__init__.py", submodule_search_locations=[str(ROOT)]
    )
    package = importlib.util.module_from_spec(spec)
    sys.modules[EXTENSION] = package
    spec.loader.exec_module(package)
    importlib.import_module(f"{EXTENSION}.properties").register()


def core(module: str) -> Any:
    """A module of the loaded extension."""
    return importlib.import_module(f"{EXTENSION}.{module}")


def direction(azimuth_deg: float, elevation_deg: float) -> Array:
    """Unit vector of a compass bearing (clockwise from +Y seen from above) and an elevation."""
    azimuth, elevation = math.radians(azimuth_deg), math.radians(elevation_deg)
    return np.array(
        [
            math.sin(azimuth) * math.cos(elevation),
            math.cos(azimuth) * math.cos(elevation),
            math.sin(elevation),
        ]
    )


def panorama(description: dict[str, Any], height: int = PANORAMA_HEIGHT, fine: int = 4) -> Any:
    """The scene's light, one basis spectrum for the ambient and each patch; edges anti-aliased by supersampling."""
    width, count = 2 * height, 1 + len(description["patches"])
    weights = np.zeros((height, width, count), np.float32)
    weights[..., 0] = 1.0
    azimuths = np.pi * (1.0 - (2.0 * np.arange(width * fine) + 1.0) / (width * fine))
    elevations = np.pi * (0.5 - (np.arange(height * fine) + 0.5) / (height * fine))
    for index, patch in enumerate(description["patches"], 1):
        towards = direction(patch["azimuth_deg"], patch["elevation_deg"])
        horizontal = np.cos(azimuths) * towards[0] + np.sin(azimuths) * towards[1]
        inside = np.empty((height, width), np.float32)
        for row in range(height):  # a strip at a time: the whole would not fit small machines
            angles = elevations[row * fine : (row + 1) * fine, None]
            cosine = np.cos(angles) * horizontal + np.sin(angles) * towards[2]
            covered = cosine > math.cos(math.radians(patch["angular_radius_deg"]))
            inside[row] = covered.reshape(fine, width, fine).mean((0, 2))
        weights[..., index] = inside
        weights[..., 0] *= 1.0 - inside
    bases = np.array([description["ambient"], *(patch["radiance"] for patch in description["patches"])])
    return core("spectral_probe.model").SpectralPanorama(
        weights=weights,
        bases=bases[None],
        basis_index=np.zeros((height, width), np.uint8),
        wavelengths_nm=np.array(description["wavelengths"], float),
        valid=np.ones((height, width), bool),
        confidence=np.ones((height, width), np.float32),
    )


def build_scene(description: dict[str, Any], folder: Path) -> bpy.types.Scene:
    """The described scene in an empty file; the materials' tables are written into a folder."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = description["size"]
    scene.render.resolution_percentage = 100
    scene.cycles.pixel_filter_type = "BOX"
    for bounces in ("max_bounces", "diffuse_bounces", "glossy_bounces"):
        setattr(scene.cycles, bounces, 12)

    view = description["camera"]
    camera = bpy.data.cameras.new("Camera")
    camera.sensor_fit, camera.angle_x = "HORIZONTAL", math.radians(view["fov_x_deg"])
    camera_object = bpy.data.objects.new("Camera", camera)
    camera_object.location = view["at"]
    gaze = Vector(view["target"]) - Vector(view["at"])
    camera_object.rotation_euler = gaze.to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(camera_object)
    scene.camera = camera_object

    nm, half = np.array(description["wavelengths"]), description["floor_half_size"]
    floor = bpy.data.meshes.new("Floor")
    floor.from_pydata(
        [(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)], [], [(0, 1, 2, 3)]
    )
    grey = material("Floor", "ShaderNodeBsdfDiffuse")
    grey.spectral_probe.kind = "REFLECTANCE"
    grey.spectral_probe.reflectance_path = table(folder / "floor.csv", nm, description["floor_reflectance"])
    floor.materials.append(grey)
    scene.collection.objects.link(bpy.data.objects.new("Floor", floor))

    for ball in description["balls"]:
        bpy.ops.mesh.primitive_uv_sphere_add(
            segments=256, ring_count=128, radius=ball["radius"], location=ball["at"]
        )
        bpy.ops.object.shade_smooth()
        metal = material(ball["metal"], "ShaderNodeBsdfMetallic")
        metal.node_tree.nodes["Shader"].distribution = "GGX"
        metal.node_tree.nodes["Shader"].inputs["Roughness"].default_value = math.sqrt(ball["ggx_alpha"])
        metal.spectral_probe.kind = "METAL"
        metal.spectral_probe.metal = table(folder / f"{ball['metal']}.csv", nm, ball["n"], ball["k"])
        bpy.context.object.data.materials.append(metal)
    return scene


def material(name: str, shader: str) -> bpy.types.Material:
    """A material of one shader, called "Shader" in its node tree."""
    made = bpy.data.materials.new(name)
    tree = made.node_tree
    tree.nodes.clear()
    node, output = tree.nodes.new(shader), tree.nodes.new("ShaderNodeOutputMaterial")
    node.name = "Shader"
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return made


def table(path: Path, *columns: Any) -> str:
    """Write columns as CSV and return the path."""
    np.savetxt(path, np.column_stack(columns), delimiter=",")
    return str(path)


def differences(xyz: Array, reference: Array) -> dict[str, Any]:
    """Mean tristimulus ratios and dE2000 of an image against a reference, blurred and exposed as described above."""
    scale = 1.0 / np.percentile(reference[..., 1], 95)
    blurred = [
        np.clip(cv2.GaussianBlur(i.astype(np.float64) * scale, (0, 0), 3.0), 0.0, 3.0)
        for i in (xyz, reference)
    ]
    white = np.array(core("spectral_probe.spectra.colorimetry").white_xyz("D65"))
    error = core("spectral_probe.spectra.colorimetry").delta_e_2000(*blurred, white)
    return {
        "mean_ratio_xyz": (xyz.mean((0, 1)) / reference.mean((0, 1))).round(5).tolist(),
        "de2000_mean": round(float(error.mean()), 3),
        "de2000_p99": round(float(np.percentile(error, 99)), 3),
        "de2000_max": round(float(error.max()), 3),
    }


def write_preview(path: Path, xyz: Array, scale: float) -> None:
    """An sRGB PNG of an XYZ image."""
    linear = np.clip(core("spectral_probe.spectra.colorimetry").xyz_to_rec709(xyz) * scale * 0.8, 0.0, 1.0)
    encoded = np.where(linear < 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    cv2.imwrite(str(path), np.round(encoded[..., ::-1] * 255).astype(np.uint8))


def main() -> None:
    """Render and compare; prints one JSON object and leaves it, with pictures, in the output folder."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="folder with scene.json and reference_xyz.npz")
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "out" / "metals_reference")
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument(
        "--passes", type=int, nargs="*", default=[0], help="light-basis plans to try; 0: automatic"
    )
    parser.add_argument("--no-reference-plan", action="store_true", help="skip the 61 wavelengths")
    options = parser.parse_args()

    load_extension()
    cycles, images = core("operators.bridge.cycles"), core("spectral_probe.files.image_exr")
    finish = core("spectral_probe.model").finish
    description = json.loads((options.folder / "scene.json").read_text())
    stored = np.load(options.folder / "reference_xyz.npz")
    reference = stored["xyz"]
    options.output.mkdir(parents=True, exist_ok=True)
    scene, probe = build_scene(description, options.output), panorama(description)

    results: dict[str, Any] = {}
    rendered: dict[str, Array] = {}
    scale = 1.0 / np.percentile(reference[..., 1], 95)
    write_preview(options.output / "reference.png", reference, scale)
    plans: list[int | str] = [*([] if options.no_reference_plan else ["all"]), *options.passes]
    for passes in plans:
        folder = options.output / f"passes_{passes}"
        job = cycles.spectral_render(
            scene, probe, None, folder, samples=options.samples, passes=passes, rgb_twin=passes == 0
        )
        result = finish(job)
        rendered[str(passes)] = images.read_rgb(result.xyz, ("X", "Y", "Z"))
        write_preview(folder / "image.png", rendered[str(passes)], scale)
        results[str(passes)] = {
            "passes": result.plan.passes,
            "seconds": round(result.seconds_spectral, 2),
            "seconds_rgb": result.seconds_rgb,
            "predicted_de2000": result.plan.predicted_de2000,
            "light_residual": result.light_residual,
            "against_reference": differences(rendered[str(passes)], reference),
        }
        if passes != "all" and "all" in rendered:
            results[str(passes)]["against_own_61"] = differences(rendered[str(passes)], rendered["all"])
    text = json.dumps(results, indent=2) + "\n"
    (options.output / "metals_reference.json").write_text(text)
    sys.stdout.write(text)


if __name__ == "__main__":
    main()
