"""Plate + (with - without) on the ground, objects elsewhere."""

from dataclasses import replace

import numpy as np
import pytest

from spectral_probe.composite.differential import differential
from spectral_probe.composite_model import ObjectCoverage
from spectral_probe.errors import RenderError

GREY = 0.3


def plate_like(image, level=1.0):
    return np.broadcast_to(level * image.mean((0, 1)), image.shape).astype(np.float32)


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def covering(cover, ground=None):
    cover = np.asarray(cover, np.float32)
    return ObjectCoverage(
        {"thing": cover}, cover, 1 - cover if ground is None else np.asarray(ground, np.float32)
    )


def test_shadow_and_colour_bleeding_are_those_of_the_noiseless_render(exact, noisy):
    plate = plate_like(exact.without)
    truth = plate + exact.with_ - exact.without
    found = differential(plate, noisy.with_, noisy.without, noisy.coverage)
    raw = differential(plate, noisy.with_, noisy.without, noisy.coverage, smooth=False)
    ground = (noisy.coverage.coverage == 0) & (exact.coverage.coverage == 0)
    relative = ((found.pixels - truth) / plate)[ground]
    assert rms(relative) < 0.03
    assert rms(relative) < 0.4 * rms(((raw.pixels - truth) / plate)[ground])
    redder = exact.with_ / exact.without
    bleeding = ground & (redder[..., 0] - redder[..., 2] > 0.02) & (exact.distance < 2)
    change = (found.pixels - plate) / plate
    assert bleeding.sum() > 100
    assert np.mean(change[..., 0] - change[..., 2], where=bleeding) > 0.015


def test_light_that_objects_add_is_added(exact):
    plate = plate_like(exact.without)
    caustic = exact.without + 0.4 * np.exp(-((exact.distance - 2) ** 2))[..., None].astype(np.float32)
    found = differential(plate, caustic, exact.without, covering(np.zeros(exact.distance.shape)))
    bright = exact.distance < 3
    truth = plate + caustic - exact.without
    np.testing.assert_allclose(
        found.pixels[bright], truth[bright], rtol=0.03
    )  # the noise of the ground alone is 2 %
    np.testing.assert_allclose((found.pixels / truth)[bright].mean(), 1, atol=0.002)


def test_pixels_far_from_the_object_are_the_plate_bit_for_bit(wide):
    random = np.random.default_rng(3)
    plate = (plate_like(wide.without) * random.uniform(0.3, 1.5, wide.without.shape)).astype(np.float32)
    found = differential(plate, wide.with_, wide.without, wide.coverage)
    far = wide.distance > 9
    assert ((wide.with_ != wide.without).any(-1) & far).sum() > 20  # paths that met the ball all the same
    np.testing.assert_array_equal(found.pixels[far], plate[far])
    assert found.changed[wide.distance < 2].all()
    assert not found.difference[~found.changed].any()


def test_the_edge_of_a_hard_shadow_stays_where_it_is():
    ground = np.ones((80, 80, 3), np.float32)
    shadow = np.where(np.arange(80) < 40, -0.6, 0.0)[None, :, None]
    noise = 0.01 * np.random.default_rng(0).standard_normal(ground.shape) * (shadow < 0)
    with_ = (ground + shadow + noise).astype(np.float32)
    found = differential(ground, with_, ground, covering(np.zeros((80, 80))))
    np.testing.assert_allclose(found.pixels[:, :39] - 0.4, 0, atol=0.05)
    np.testing.assert_allclose(found.pixels[:, 41:], 1, atol=0.05)


def test_texture_of_the_ground_stays_in_the_shadow():
    texture = np.random.default_rng(0).uniform(0.3, 0.7, (60, 60, 1)).astype(np.float32) * np.ones(
        3, np.float32
    )
    noise = 1 + 0.05 * np.random.default_rng(1).standard_normal(texture.shape)
    found = differential(
        texture, (0.4 * texture * noise).astype(np.float32), texture, covering(np.zeros((60, 60)))
    )
    ratio = (found.pixels / texture)[10:-10, 10:-10]
    assert abs(ratio.mean() - 0.4) < 0.005
    assert ratio.std() < 0.03


def test_edges_are_premultiplied_and_have_no_halo():
    """An object over the sky and over the ground, its edge through pixels of any coverage."""
    plate = np.full((2, 11, 3), [0.9, 0.8, 0.7], np.float32)
    cover = np.repeat(np.linspace(0, 1, 11)[None], 2, 0)
    ground = (1 - cover) * [[0], [1]]
    with_ = (cover * GREY + ground * 0.5)[..., None] * np.ones(3)
    without = np.array([0.0, 0.5])[:, None, None] * np.ones((2, 11, 3))
    alpha = np.array([[0.0], [1.0]]) * np.ones((2, 11))
    for known in (alpha, None):
        found = differential(plate, with_, without, covering(cover, ground), without_alpha=known)
        np.testing.assert_allclose(
            found.pixels, plate * (1 - cover)[..., None] + GREY * cover[..., None], atol=1e-6
        )


def test_an_edge_over_the_horizon_keeps_both_sides():
    """Object, ground and sky in one pixel: the object hides as much of the one as of the other."""
    plate = np.full((1, 1, 3), 0.8, np.float32)
    with_ = np.full((1, 1, 3), 0.5 * GREY + 0.25 * 0.3)  # the ground, shaded to 0.3 of 0.6
    without = np.full((1, 1, 3), 0.5 * 0.6)
    found = differential(plate, with_, without, covering([[0.5]], [[0.25]]), without_alpha=np.array([[0.5]]))
    np.testing.assert_allclose(found.pixels, 0.5 * 0.8 + 0.5 * GREY - 0.25 * 0.3, atol=1e-6)


def test_a_plate_darker_than_the_render_is_not_shaded_to_black():
    ground, plate = np.full((40, 40, 3), 0.6, np.float32), np.full((40, 40, 3), [0.2, 0.15, 0.1], np.float32)
    found = differential(plate, 0.2 * ground, ground, covering(np.zeros((40, 40))))
    assert found.limited.all()
    np.testing.assert_allclose(found.pixels, 0.2 * plate, rtol=1e-3)


def test_negative_noise_of_a_plate_is_left_where_nothing_is_done():
    plate = np.full((4, 4, 3), -0.001, np.float32)
    found = differential(plate, np.zeros_like(plate), None, covering(np.zeros((4, 4))))
    np.testing.assert_array_equal(found.pixels, plate)
    assert not found.changed.any()


def test_an_object_without_any_ground_hides_the_plate():
    plate, render = np.full((1, 2, 3), 0.5, np.float32), np.zeros((1, 2, 3), np.float32)
    render[0, 0] = 0.2
    found = differential(plate, render, None, covering([[1.0, 0.0]], [[0.0, 0.0]]))
    np.testing.assert_allclose(found.pixels[0, :, 0], [0.2, 0.5])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"with_": np.zeros((3, 3, 3))}, "3 x 3 pixels, the plate 4 x 2"),
        ({"without": np.full((2, 4, 3), np.nan)}, "without the objects holds values that are not numbers"),
        ({"plate": np.full((2, 4, 3), np.inf)}, "plate holds values that are not numbers"),
    ],
)
def test_bad_images_are_refused(change, message):
    images = {
        "plate": np.ones((2, 4, 3)),
        "with_": np.ones((2, 4, 3)),
        "without": np.ones((2, 4, 3)),
    } | change
    with pytest.raises(RenderError, match=message):
        differential(images["plate"], images["with_"], images["without"], covering(np.zeros((2, 4))))


def test_coverage_of_another_size_is_refused(exact):
    small = replace(exact.coverage, coverage=np.zeros((2, 2)), ground=np.zeros((2, 2)))
    with pytest.raises(RenderError, match=r"objects\.exr"):
        differential(exact.with_, exact.with_, exact.without, small)


# ---------------------------------------------------------------- shadows


def around(size, radius):
    rows, columns = np.mgrid[:size, :size] - (size - 1) / 2
    return np.exp(-(rows**2 + columns**2) / (2 * radius**2))[..., None] * np.ones(3)


def rendered(ground, change, *, noise=0.0, common=0.05, seed=0):
    """The ground with and without its relative change; one part of the noise is common to both."""
    random = np.random.default_rng(seed)
    without = ground * (1 + common * random.standard_normal((*ground.shape[:2], 1)))
    own = noise * np.sqrt(np.abs(change)) * random.standard_normal((*ground.shape[:2], 1))
    return (without * (1 + change + own)).astype(np.float32), without.astype(np.float32)


def test_a_small_shadow_keeps_its_depth():
    ground = np.full((64, 64, 3), 0.4, np.float32)
    change = -0.7 * around(64, 3.0)
    with_, without = rendered(ground, change, noise=0.06)
    found = differential(ground, with_, without, covering(np.zeros((64, 64))))
    inside = change[..., 0] < -0.1
    error = (found.pixels / ground - 1 - change)[inside]
    assert abs(error.mean()) < 0.01  # a plain mean of the least width: 0.02
    assert rms(error) < 0.04


def test_smoothing_leaves_local_means_as_they_are(exact, noisy):
    plate = plate_like(exact.without)
    ground = (noisy.coverage.coverage == 0) & (exact.coverage.coverage == 0)
    truth = plate * exact.with_ / exact.without

    def local(pixels):
        error = np.where(ground[..., None], (pixels - truth) / plate, 0)[:90, :90]
        return rms(error.reshape(15, 6, 15, 6, 3).mean((1, 3)))

    smooth, raw = (
        differential(plate, noisy.with_, noisy.without, noisy.coverage, smooth=on).pixels
        for on in (True, False)
    )
    assert local(smooth) < 0.9 * local(raw)


def test_texture_that_only_the_photograph_has_is_shaded_in_proportion():
    rows, columns = np.mgrid[:96, :96] // 12
    plate = np.where((rows + columns)[..., None] % 2, 0.65, 0.15) * np.ones(3, np.float32)
    change = -0.6 * around(96, 14.0)
    with_, without = rendered(np.full_like(plate, 0.4), change, noise=0.02)
    found = differential(plate.astype(np.float32), with_, without, covering(np.zeros((96, 96))))
    inside = change[..., 0] < -0.05
    ratio = (found.pixels / plate)[inside] / (1 + change)[inside]
    np.testing.assert_allclose(ratio, 1, atol=0.1)
    assert rms(ratio - 1) < 0.025


def test_where_only_the_level_differs_the_difference_is_added():
    plate, ground = np.full((64, 64, 3), 0.5, np.float32), np.full((64, 64, 3), 0.6, np.float32)
    with_ = (ground * (1 - 0.5 * around(64, 8.0))).astype(np.float32)
    found = differential(plate, with_, ground, covering(np.zeros((64, 64))))
    np.testing.assert_allclose(found.pixels, plate + with_ - ground, atol=0.006)


def test_an_object_lights_a_ground_that_was_dark():
    plate, dark = np.full((40, 40, 3), 0.02, np.float32), np.zeros((40, 40, 3), np.float32)
    lit = (0.3 * around(40, 8.0)).astype(np.float32)
    found = differential(plate, lit, dark, covering(np.zeros((40, 40))))
    np.testing.assert_allclose(found.pixels, plate + lit, atol=0.005)


@pytest.mark.parametrize("level", [0.6, 0.3])
def test_edges_in_a_deep_shadow_have_no_specks(level):
    """An edge of any coverage over ground that keeps a twentieth of its light and is noisy in the open."""
    size = 48
    cover = np.clip((np.arange(size) - 20) / 6, 0, 1)[None] * np.ones((size, 1))
    ground, keeps = np.full((size, size, 3), level), 0.05
    shaded, without = rendered(ground, np.full_like(ground, keeps - 1), common=0.1)
    with_ = (cover[..., None] * GREY + (1 - cover)[..., None] * shaded).astype(np.float32)
    plate = np.full((size, size, 3), 0.6, np.float32)
    found = differential(plate, with_, without, covering(cover))
    truth = cover[..., None] * GREY + (1 - cover)[..., None] * keeps * plate
    if level != 0.6:  # the photograph is brighter than the render by light that no object takes
        truth += (1 - cover)[..., None] * (plate - level) * (1 - keeps)
    np.testing.assert_allclose(found.pixels[:, 21:26], truth[:, 21:26], atol=0.02)


def test_the_sky_above_the_horizon_takes_no_shadow():
    plate, change = np.full((60, 60, 3), 0.5, np.float32), -0.5 * around(60, 20.0)
    share = np.clip((np.arange(60) - 28) / 4, 0, 1)[:, None] * np.ones((1, 60))
    without = np.asarray(0.5 * share[..., None] * np.ones(3), np.float32)
    with_ = (without * (1 + change)).astype(np.float32)
    cover = covering(np.zeros((60, 60)), share)
    found = differential(plate, with_, without, cover, without_alpha=share)
    np.testing.assert_array_equal(found.pixels[:29], plate[:29])
    np.testing.assert_allclose(found.pixels, plate * (1 + share[..., None] * change), atol=0.01)


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_a_faint_wide_shadow_ends_without_an_edge(noise):
    plate = np.full((160, 160, 3), 0.5, np.float32)
    change = -0.03 * around(160, 30.0)
    with_, without = rendered(plate, change, noise=noise)
    found = differential(plate, with_, without, covering(np.zeros((160, 160))))
    codes = np.round(255 * found.pixels ** (1 / 2.2)) - np.round(255 * (plate * (1 + change)) ** (1 / 2.2))
    assert np.abs(codes).max() <= 1
    assert not found.changed[:8].any()
