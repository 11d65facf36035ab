"""Passes with few samples against passes with all, in Cycles: the same light, object by object."""

from dataclasses import replace

import bpy
import numpy as np
import pytest

SAMPLES = 128
TOLERANCE = 0.01  # of an object's mean; 8 of 128 samples on a few hundred pixels, same seed


@pytest.fixture
def two_balls(scene, ball):
    """A red and a blue ball on a grey floor, lit by a bright window in a dim surrounding; few pixels."""
    scene.render.resolution_x, scene.render.resolution_y = 80, 48
    for number, (x, colour) in enumerate(((-1.1, (0.7, 0.08, 0.05)), (1.1, (0.05, 0.15, 0.7))), start=1):
        material = ball(location=(x, 0.0, 0.0))
        material.node_tree.nodes["Shader"].inputs["Color"].default_value = (*colour, 1.0)
        bpy.context.object.pass_index = number
    bpy.ops.mesh.primitive_plane_add(size=12.0, location=(0.0, 0.0, -1.0))
    grey = bpy.data.materials.new("Floor")
    bpy.context.object.data.materials.append(grey)
    scene.camera.location = (0.0, -6.0, 1.0)
    return scene


@pytest.fixture
def window(extension):
    """Dim red light from everywhere and a bright bluish window."""
    weights = np.zeros((16, 32, 2), np.float32)
    weights[..., 0] = 1.0
    weights[3:6, 4:9, 1] = 20.0
    ramp = np.linspace(0.5, 1.5, 61)
    return extension("spectral_probe.model").SpectralPanorama(
        weights=weights,
        bases=np.stack([ramp, ramp[::-1]])[None],
        basis_index=np.zeros((16, 32), np.uint8),
        wavelengths_nm=np.arange(400.0, 701.0, 5.0),
        valid=np.ones((16, 32), bool),
        confidence=np.ones((16, 32), np.float32),
    )


def test_few_samples_give_the_light_of_all(two_balls, window, bridge, extension, tmp_path):
    finish, read = (
        extension("spectral_probe.model").finish,
        extension("spectral_probe.files.image_exr").read_rgb,
    )
    planning = extension("operators.bridge.planning")
    few = bridge.planned(two_balls, planning.Planner(window, planning.PlanRequest(4), SAMPLES))
    assert len(set(few.references)) < few.passes, "no pass is a ratio of another"
    every = replace(few, sample_shares=np.ones(few.passes), references=tuple(range(few.passes)))
    images = []
    for name, plan in (("few", few), ("all", every)):
        job = bridge.spectral_render(
            two_balls, window, plan, tmp_path / name, samples=SAMPLES, rgb_twin=False
        )
        images.append(read(finish(job).xyz, ("X", "Y", "Z")))
    estimate, truth = images
    index = read_index(tmp_path / "few", extension)
    for number in (0, 1, 2):
        chosen = index == number
        assert chosen.sum() > 100
        np.testing.assert_allclose(estimate[chosen].mean(0), truth[chosen].mean(0), rtol=TOLERANCE)
    error = np.abs(estimate - truth).mean() / truth.mean()
    assert error < 0.03


def read_index(directory, extension):
    """(H, W) object index, from the features of the first step; -1 on edges, where 8 samples see more or less of an object."""
    reader = extension("spectral_probe.render.pass_folder").read_pass
    guides = (reader(path).guide for path in sorted((directory / "passes").glob("*.exr")))
    index = next(guide for guide in guides if guide is not None)[..., 6]
    around = np.stack([np.roll(index, shift, axis) for axis in (0, 1) for shift in (-1, 1)])
    return np.where(np.ptp(around, axis=0) < 0.01, np.round(index), -1)
