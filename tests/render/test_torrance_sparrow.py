"""The node group against eq. 12 integrated in numpy, on balls of gold; the differences that remain are docs/paper.md's."""

import math

import bpy
import numpy as np
import pytest

SIZE_PX = 24


@pytest.fixture
def ball_view(scene):
    """The scene's camera sees, without perspective, a ball that fills the picture."""
    scene.render.resolution_x = scene.render.resolution_y = SIZE_PX
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.use_denoising = False
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 2.0
    bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64)
    bpy.ops.object.shade_smooth()
    return bpy.context.object


@pytest.fixture
def panorama(extension):
    """Light of two spectra: smooth, or a dim room with five lamps of 6 to 12 degrees."""
    frames = extension("spectral_probe.geometry.frames")
    library = extension("spectral_probe.spectra.library")

    def make(kind, height=64):
        directions = frames.panorama_directions(height, 2 * height)
        weights = np.zeros((height, 2 * height, 2), np.float32)
        if kind == "smooth":
            weights[..., 0] = 0.6 + 0.5 * directions[..., 2]
            weights[..., 1] = 0.3 * (1.0 + 0.9 * directions[..., 0])
        else:
            weights[..., 1] = 0.1
            lamps = (
                (200, 45, 9, 20),
                (130, 20, 6, 30),
                (250, -20, 12, 8),
                (60, 30, 8, 25),
                (180, -50, 10, 10),
            )
            for azimuth, elevation, radius, power in lamps:
                towards = frames.bearing_to_direction(azimuth, elevation)
                weights[..., 0] += power * (directions @ towards > math.cos(math.radians(radius)))
        return extension("spectral_probe.model").SpectralPanorama(
            weights=weights,
            bases=np.stack([library.planck(2856.0), library.daylight(6500.0)])[None],
            basis_index=np.zeros(weights.shape[:2], np.uint8),
            wavelengths_nm=np.arange(400.0, 701.0, 5.0),
            valid=np.ones(weights.shape[:2], bool),
            confidence=np.ones(weights.shape[:2], np.float32),
        )

    return make


@pytest.fixture
def both(scene, bridge, extension, ball_view, three_wavelengths, tmp_path):
    """Render a surface in Cycles and in numpy: XYZ images of three wavelengths."""
    reference = extension("spectral_probe.render.torrance_sparrow")
    to_xyz = extension("spectral_probe.spectra.colorimetry").spectra_to_xyz

    def render(light, *, samples=64, **parameters):
        group = extension("operators.bridge.torrance_sparrow")
        material = group.torrance_sparrow_material("Surface", metal="Au", **parameters)
        node = next(n for n in material.node_tree.nodes if n.type == "GROUP")
        node.inputs["Diffuse Color"].default_value = (1.0, 1.0, 1.0, 1.0)
        ball_view.data.materials.append(material)
        job = bridge.spectral_render(
            scene, light, three_wavelengths, tmp_path / "out", samples=samples, rgb_twin=False
        )
        result = extension("spectral_probe.model").finish(job)
        rendered = extension("spectral_probe.files.image_exr").read_rgb(result.xyz, ("X", "Y", "Z"))
        surface = reference.TorranceSparrowSurface.metal("Au", **parameters)
        paper = reference.sphere_image(light, surface, SIZE_PX, supersampling=1).radiance
        return rendered, to_xyz(paper * three_wavelengths.reconstruction.sum((0, 1)))

    return render


def ring(least, most):
    """Mask of the pixels at a distance from the ball's middle, in radii: sines of the viewing angle."""
    rows, columns = (np.mgrid[:SIZE_PX, :SIZE_PX] + 0.5) / SIZE_PX * 2.0 - 1.0
    distance = np.hypot(rows, columns)
    return (distance >= least) & (distance < most)


def lobe_of_albedo(albedo, gamma_rad):
    return albedo * math.log(2.0) / (4.0 * math.pi * gamma_rad**2)


@pytest.mark.parametrize(
    ("kind", "gamma_deg", "inner", "outer"),
    [("smooth", 3.0, 0.005, 0.01), ("spotty", 8.0, 0.05, 0.05), ("smooth", 25.0, 0.05, 0.12)],
)
def test_the_lobe_is_the_papers(both, panorama, kind, gamma_deg, inner, outer):
    """Mean tristimulus values up to 50 degrees of viewing angle, and from there to 70, where shadowing differs."""
    gamma = math.radians(gamma_deg)
    cycles, paper = both(panorama(kind), beta=lobe_of_albedo(0.8, gamma), gamma_rad=gamma)
    for mask, tolerance in ((ring(0.0, 0.766), inner), (ring(0.766, 0.94), outer)):
        np.testing.assert_allclose(cycles[mask].mean(0) / paper[mask].mean(0), 1.0, atol=tolerance)


def test_diffuse_and_mirror_parts_are_exact(both, panorama):
    cycles, paper = both(panorama("smooth"), alpha=0.15, beta=0.0, beta_mirror=0.6, gamma_rad=0.1)
    mask = ring(0.0, 0.94)
    np.testing.assert_allclose(cycles[mask].mean(0) / paper[mask].mean(0), 1.0, atol=0.005)
    relative = (cycles[mask] - paper[mask]) / paper[mask].mean(0)
    assert np.sqrt((relative**2).mean()) < 0.03


def test_weights_above_one_are_not_cut(both, uniform_light):
    """Eq. 12 may reflect more than falls in: diffuse 2, lobe 12, mirror 3 times what a perfect one would."""
    gamma = math.radians(3.0)
    light = uniform_light(np.ones(61), height=32)
    weights = {"alpha": 2.0 / math.pi, "beta": lobe_of_albedo(12.0, gamma), "beta_mirror": 3.0}
    cycles, paper = both(light, samples=16, gamma_rad=gamma, **weights)
    mask = ring(0.0, 0.766)
    np.testing.assert_allclose(cycles[mask].mean(0) / paper[mask].mean(0), 1.0, atol=0.01)


def test_the_rgb_render_shows_the_same_surface(scene, bridge, extension, ball_view, uniform_light, tmp_path):
    """In daylight the plain Cycles material, the spectral passes and the RGB twin agree."""
    library = extension("spectral_probe.spectra.library")
    group = extension("operators.bridge.torrance_sparrow")
    ball_view.data.materials.append(
        group.torrance_sparrow_material("Surface", alpha=0.05, beta=2.8, beta_mirror=0.1)
    )
    job = bridge.spectral_render(
        scene, uniform_light(library.daylight(6504.0)), None, tmp_path / "out", samples=16, passes=5
    )
    result = extension("spectral_probe.model").finish(job)
    read_rgb = extension("spectral_probe.files.image_exr").read_rgb
    spectral, plain = (read_rgb(path)[ring(0.0, 0.5)].mean(0) for path in (result.image, result.rgb))
    np.testing.assert_allclose(
        plain, spectral, rtol=0.05
    )  # a colour times a colour is not a spectrum times one
