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
