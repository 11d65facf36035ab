"""Blender for render tests: isolated from the user's own settings before it is imported."""

import importlib
import importlib.util
import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

EXTENSION = "spectral_probe_extension"

# Blender reads this when bpy is imported, unless tests of another folder did so in the same process.
_resources = tempfile.TemporaryDirectory(prefix="spectral_probe_blender_")
if "bpy" not in sys.modules:
    os.environ["BLENDER_USER_RESOURCES"] = _resources.name

import bpy  # noqa: E402  (not before its folders are set)


@pytest.fixture(scope="module")
def extension(project_root: Path) -> Iterator[Callable[[str], ModuleType]]:
    """Look up a module of the checkout, loaded as a package; settings of scenes and materials are attached."""
    if EXTENSION not in sys.modules:
        spec = importlib.util.spec_from_file_location(
            EXTENSION, project_root / "__init__.py", submodule_search_locations=[str(project_root)]
        )
        sys.modules[EXTENSION] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules[EXTENSION])
    properties = importlib.import_module(f"{EXTENSION}.properties")
    properties.register()
    yield lambda name: importlib.import_module(f"{EXTENSION}.{name}")
    properties.unregister()


@pytest.fixture
def scene(extension: Any) -> Iterator[Any]:  # noqa: ARG001  (settings must be attached before the file is read)
    """An empty Cycles scene of 64 x 64 pixels, seen from (0, -5, 0) along +Y."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = 64
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.0, -5.0, 0.0), (1.5707963, 0.0, 0.0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    yield scene
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


@pytest.fixture
def bridge(extension: Any) -> ModuleType:
    return extension("operators.bridge.cycles")


@pytest.fixture
def uniform_light(extension: Any):
    """Make a panorama of one spectrum (61,) from everywhere."""

    def make(spectrum: Any, height: int = 8) -> Any:
        return extension("spectral_probe.model").SpectralPanorama(
            weights=np.ones((height, 2 * height, 1), np.float32),
            bases=np.asarray(spectrum, float)[None, None],
            basis_index=np.zeros((height, 2 * height), np.uint8),
            wavelengths_nm=np.arange(400.0, 701.0, 5.0),
            valid=np.ones((height, 2 * height), bool),
            confidence=np.ones((height, 2 * height), np.float32),
        )

    return make


@pytest.fixture
def three_wavelengths(extension: Any) -> Any:
    """A plan of one pass: 450, 550 and 650 nm in its channels, the spectrum zero elsewhere."""
    grid = np.arange(400.0, 701.0, 5.0)
    reconstruction = np.zeros((1, 3, 61))
    reconstruction[0, range(3), (10, 30, 50)] = 1.0
    return extension("spectral_probe.render_model").PassPlan(
        kind="wavelength",
        wavelengths_nm=grid[[[10, 30, 50]]],
        reconstruction=reconstruction,
        grid_nm=grid,
        sample_shares=np.ones(1),
        references=(0,),
        light_sets=(0,),
    )


@pytest.fixture
def ball():
    """Add a smooth ball of radius 1 with a one-shader material to the scene."""

    def add(
        shader: str = "ShaderNodeBsdfDiffuse", location: tuple[float, float, float] = (0.0, 0.0, 0.0)
    ) -> Any:
        bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48, location=location)
        bpy.ops.object.shade_smooth()
        material = bpy.data.materials.new("Material")
        tree = material.node_tree
        tree.nodes.clear()
        node, output = tree.nodes.new(shader), tree.nodes.new("ShaderNodeOutputMaterial")
        node.name = "Shader"
        tree.links.new(node.outputs[0], output.inputs["Surface"])
        bpy.context.object.data.materials.append(material)
        return material

    return add


GRID_NM = np.arange(400.0, 701.0, 5.0)


@pytest.fixture
def radiance(scene: Any, extension: Any, tmp_path: Path) -> Callable[..., Any]:
    """Spectral radiance (M, H, W) of the scene at wavelengths, by passes of either kind, without a plan; and the warnings.

    The world is dark, or of one spectrum (61,) from everywhere. `light_sets` 0 leaves the emission out.
    """
    spectral_materials = extension("operators.bridge.materials").spectral_materials
    temporary_light = extension("operators.bridge.world").temporary_light

    def render(
        wavelengths_nm: Any,
        kind: str = "light-basis",
        world: Any = None,
        samples: int = 8,
        level: float = 0.03,
        emission: bool = True,
    ) -> Any:
        one = kind == "light-basis"
        nm = np.asarray(wavelengths_nm, float)
        triples = [np.full(3, w) for w in nm] if one else list(nm.reshape(-1, 3))
        _plain_settings(scene, samples)
        world = np.zeros(61) if world is None else np.asarray(world, float)
        images: list[Any] = []
        with (
            spectral_materials(scene, one_wavelength=one, level=level) as materials,
            temporary_light(scene, 8, 16) as set_light,
        ):
            if not emission:
                materials.shine(False)
            for triple in triples:
                materials.set_wavelengths(triple)
                light = np.array([np.interp(w, GRID_NM, world) for w in triple]) / level
                set_light(
                    np.broadcast_to(
                        np.array([1.0, 0.0, 0.0]) * bool(world.any()) if one else light, (8, 16, 3)
                    )
                )
                groups = _render_groups(scene, tmp_path)
                if not one:
                    images.extend(np.moveaxis(groups["Combined"], -1, 0) * level)
                    continue
                at = {
                    g.name: [np.interp(triple[0], GRID_NM, s) for s in g.spectra] for g in materials.emission
                }
                total = groups["Combined_world" if materials.emission else "Combined"][..., 0] * np.interp(
                    triple[0], GRID_NM, world
                )
                images.append(total + sum(groups[f"Combined_{name}"] @ np.array(s) for name, s in at.items()))
            return np.stack(images), materials.warnings

    return render


@pytest.fixture
def render_groups(scene: Any, tmp_path: Path) -> Callable[[], dict[str, Any]]:
    """Render with settings of spectral passes; the image and light groups by name."""

    def render() -> dict[str, Any]:
        _plain_settings(scene, 4)
        return _render_groups(scene, tmp_path)

    return render


def _plain_settings(scene: Any, samples: int) -> None:
    """What spectral passes set: nothing that biases."""
    cycles = scene.cycles
    cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = samples, False, False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0


def _render_groups(scene: Any, directory: Path) -> dict[str, Any]:
    """Render the scene: (H, W, 3) of the image, "Combined", and of every light group."""
    import OpenEXR

    image, path = scene.render.image_settings, directory / "groups.exr"
    image.media_type = "MULTI_LAYER_IMAGE"
    image.file_format, image.color_depth, image.use_exr_interleave = "OPEN_EXR_MULTILAYER", "32", True
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    layer = scene.view_layers[0].name
    names = {name.split(".")[1] for name in channels if name.startswith(f"{layer}.Combined")}
    return {name: np.stack([channels[f"{layer}.{name}.{c}"].pixels for c in "RGB"], -1) for name in names}


@pytest.fixture(scope="session")
def go_on():
    """Let a job go on until it has told so many different things: planning, then one before each render."""

    def run(job, count):
        told = set()
        while len(told) < count:
            told.add(next(job).message)

    return run
