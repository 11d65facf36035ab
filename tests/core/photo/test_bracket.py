"""Brackets with a known camera, known exposures and known light: what is found out, what is said, what is merged."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from spectral_probe.errors import PhotographError
from spectral_probe.model import Exposure, Photograph
from spectral_probe.photo.bracket import merge_bracket
from spectral_probe.photo.merge import merge
from spectral_probe.photo.read import read_photograph, srgb_to_linear
from spectral_probe.photo.samples import linear_to_srgb

SIZE = 240
ON_BALL = np.hypot(*(np.mgrid[:SIZE, :SIZE] + 0.5 - SIZE / 2)) < 115
DECODED = srgb_to_linear(np.arange(256) / 255.0).astype(np.float32)


def scene(seed=0):
    """Radiance (H, W, 3) over some eight EV, smooth and sharp detail, not grey."""
    noise = np.random.default_rng(seed).normal(size=(SIZE, SIZE, 4)).astype(np.float32)
    mixed = 1.4 * noise[..., 3:] + 0.3 * noise[..., :3]
    detail = sum(cv2.GaussianBlur(mixed, (0, 0), s) * s for s in (4, 12, 30))
    return np.exp(1.3 * detail / detail.std())


def s_curve(light):
    """A contrasty camera's tone curve, light 0..1 to codes 0..1: a dark toe and a shoulder."""
    encoded = np.clip(light, 0.0, 1.0) ** (1 / 2.2)
    return encoded**1.4 / (encoded**1.4 + (1.0 - encoded) ** 1.4)


def jpeg(radiance, exposure, name, seed=0):
    noise = np.random.default_rng(seed).normal(0.0, 0.8, radiance.shape)
    codes = np.clip(np.round(255 * s_curve(radiance * exposure.relative) + noise), 0, 255).astype(np.uint8)
    return Photograph(Path(name), DECODED[codes], codes.max(-1) >= 250, exposure, display_referred=True)


def raw(radiance, exposure, name, seed=0):
    random = np.random.default_rng(seed)
    electrons = 30000.0 * 100.0 / exposure.iso
    values = random.poisson(radiance * exposure.relative * electrons) / electrons
    values = np.minimum(values + random.normal(0.0, 2e-4, values.shape), 1.0).astype(np.float32)
    return Photograph(Path(name), values, (values >= 0.98).any(-1), exposure)


def bracket(camera, times, radiance=None, isos=None):
    radiance = scene() if radiance is None else radiance
    isos = isos or [100.0] * len(times)
    exposures = [Exposure(time_s, iso) for time_s, iso in zip(times, isos, strict=True)]
    return [camera(radiance, e, f"p{n}.x", n) for n, e in enumerate(exposures)], exposures


def times(exposures, index, factor):
    return [replace(e, time_s=e.time_s * factor) if n == index else e for n, e in enumerate(exposures)]


@pytest.mark.parametrize(
    "steps", [(0.05, 0.2, 0.8), (0.1, 0.2, 0.4), (0.1, 0.4), (0.02, 0.08, 0.3, 1.2, 5.0)]
)
def test_an_s_shaped_response_is_recovered(steps):
    """With equal steps, with two exposures, with many: mid-tones within 4 %, merged ratios within 2.5 % RMS."""
    merged = merge_bracket(*bracket(jpeg, steps), ON_BALL)
    assert merged.warnings == ()
    codes = np.array([48, 64, 96, 128, 160, 192, 224]) / 255
    light = np.linspace(0.0, 1.0, 100_001)
    truth = np.interp(codes, s_curve(light), light)
    found = merged.response.linear(np.repeat(srgb_to_linear(codes)[:, None], 3, axis=1))
    ratio = found / truth[:, None]
    np.testing.assert_allclose(ratio / ratio[3], 1.0, atol=0.04)
    seen = ON_BALL & merged.image.valid
    ratio = merged.image.radiance[seen] / scene()[seen]
    assert np.log(ratio / np.median(ratio, axis=0)).std() < 0.025
    assert np.abs(merged.offsets_ev).max() < 0.02
    assert max(merged.response.residual_ev) < 0.03


def test_the_estimated_response_beats_srgb():
    photographs, exposures = bracket(jpeg, (0.05, 0.2, 0.8))
    estimated, assumed = merge_bracket(photographs, exposures, ON_BALL).image, merge(photographs, exposures)
    seen = ON_BALL & estimated.valid
    errors = [np.log(one.radiance[seen] / scene()[seen]).std() for one in (estimated, assumed)]
    assert errors[0] < 0.1 * errors[1]


def test_a_grey_world_stays_neutral_in_mid_tones():
    grey = np.repeat(scene()[..., :1], 3, axis=-1)
    merged = merge_bracket(*bracket(jpeg, (0.05, 0.2, 0.8), grey), ON_BALL)
    middle = merged.response.linear(np.full((1, 3), srgb_to_linear(np.array(0.5))))
    np.testing.assert_allclose(middle, srgb_to_linear(np.array(0.5)), rtol=0.01)
    colour = merged.image.radiance[ON_BALL & merged.image.valid]
    assert np.abs(np.log(colour / colour.mean(-1, keepdims=True))).mean() < 0.02


def test_the_response_is_monotone_to_both_ends():
    response = merge_bracket(*bracket(jpeg, (0.1, 0.2, 0.4)), ON_BALL).response
    light = response.linear(np.repeat(DECODED[:, None], 3, axis=1))
    assert (np.diff(light, axis=0) > 0).all()
    assert 0.3 < light[-1].min() <= light[-1].max() < 5.0


@pytest.mark.parametrize("camera", [jpeg, raw])
def test_one_exposure_keeps_srgb_or_the_sensor(camera):
    photographs, exposures = bracket(camera, (0.2,))
    merged = merge_bracket(photographs, exposures, ON_BALL)
    assert merged.response is None
    assert len(merged.warnings) == (camera is jpeg)
    if camera is jpeg:
        assert "sRGB's tone curve is assumed" in merged.warnings[0]
    np.testing.assert_allclose(
        merged.image.radiance[ON_BALL], photographs[0].pixels[ON_BALL] / 0.2, rtol=2e-3, atol=1e-3
    )


@pytest.mark.parametrize("camera", [jpeg, raw])
@pytest.mark.parametrize(("index", "factor"), [(0, 2.0), (2, 0.6), (3, 1.5)])
def test_a_wrong_exposure_is_named_and_replaced(camera, index, factor):
    photographs, right = bracket(camera, (0.05, 0.15, 0.6, 2.0))
    stated = times(right, index, factor)
    merged = merge_bracket(photographs, stated, ON_BALL)
    assert len(merged.warnings) == 1
    assert merged.warnings[0].startswith(f"p{index}.x: the stated exposure")
    assert merged.offsets_ev[index] == pytest.approx(-np.log2(factor), abs=0.04)
    assert merged.exposures[index].time_s == pytest.approx(right[index].time_s, rel=0.03)
    others = [n for n in range(4) if n != index]
    assert [merged.exposures[n] for n in others] == [right[n] for n in others]
    kept = merge_bracket(photographs, stated, ON_BALL, solve_exposures=False)
    assert list(kept.exposures) == stated
    assert "solve_exposures = false" in kept.warnings[0]


@pytest.mark.parametrize("camera", [jpeg, raw])
def test_right_exposures_and_a_change_of_iso_pass_without_a_word(camera):
    merged = merge_bracket(*bracket(camera, (0.05, 0.1, 0.4), isos=[100.0, 200.0, 400.0]), ON_BALL)
    assert merged.warnings == ()
    assert np.abs(merged.offsets_ev).max() < 0.03
    ratio = (merged.image.radiance / scene())[ON_BALL & merged.image.valid]
    assert np.log(ratio / np.median(ratio, axis=0)).std() < 0.03


@pytest.mark.parametrize("camera", [jpeg, raw])
def test_reversed_times_are_named_and_turned_round(camera):
    photographs, right = bracket(camera, (0.05, 0.2, 0.8))
    merged = merge_bracket(photographs, right[::-1], ON_BALL)
    assert len(merged.warnings) == 1
    assert "opposite to the pictures' brightness" in merged.warnings[0]
    assert [e.time_s for e in merged.exposures] == pytest.approx([e.time_s for e in right], rel=1e-6)
    kept = merge_bracket(photographs, right[::-1], ON_BALL, solve_exposures=False)
    assert list(kept.exposures) == right[::-1]


def test_gamma_encoded_pictures_taken_as_linear_are_told():
    """What most programs write as 16-bit TIFF."""
    photographs, exposures = bracket(raw, (0.05, 0.2, 0.8))
    encoded = [replace(p, pixels=linear_to_srgb(p.pixels).astype(np.float32)) for p in photographs]
    merged = merge_bracket(encoded, exposures, ON_BALL)
    assert len(merged.warnings) == 1
    assert "gamma-encoded" in merged.warnings[0]
    assert list(merged.exposures) == exposures


@pytest.mark.parametrize("camera", [jpeg, raw])
def test_one_exposure_under_two_names_is_caught_without_a_response(camera):
    photographs, right = bracket(camera, (0.05, 0.2, 0.2))
    merged = merge_bracket(photographs, times(right, 2, 0.25), ON_BALL)
    assert merged.warnings[0].startswith("p1.x and p2.x are the same exposure")
    relative = [e.relative for e in merged.exposures]
    assert relative[2] / relative[1] == pytest.approx(1.0, abs=0.03)


def test_a_copy_is_left_out_and_said():
    photographs, exposures = bracket(raw, (0.05, 0.2, 0.8))
    copy = replace(photographs[1], path=Path("copy.x"), pixels=photographs[1].pixels.copy())
    merged = merge_bracket([*photographs, copy], [*exposures, exposures[1]], ON_BALL)
    assert merged.warnings == ("copy.x is the same picture as p1.x; copy.x is left out.",)
    alone = merge_bracket(photographs, exposures, ON_BALL)
    np.testing.assert_allclose(merged.image.radiance, alone.image.radiance, rtol=1e-5)


@pytest.mark.parametrize("camera", [jpeg, raw])
def test_who_walked_through_one_photograph_is_left_out(camera):
    calm = np.clip(scene(), 0.3, 3.0)
    exposures = [Exposure(0.1), Exposure(0.2), Exposure(0.4)]
    crowd = calm.copy()
    crowd[90:130, 60:90] *= 0.25
    photographs = [camera(crowd if n == 1 else calm, e, f"p{n}.x", n) for n, e in enumerate(exposures)]
    merged = merge_bracket(photographs, exposures, ON_BALL)
    inside = np.s_[95:125, 65:85]
    assert merged.moved[inside].all()
    assert merged.moved[ON_BALL].mean() < 0.08
    ratio = merged.image.radiance / calm
    assert np.median(ratio[inside]) == pytest.approx(np.median(ratio[ON_BALL]), rel=0.03)
    assert merged.image.valid[inside].all()


def test_edges_half_a_pixel_off_and_lamps_are_not_moved():
    sharp = np.where(scene(2) > 1.0, 2.0, 0.1).astype(np.float32)
    cv2.circle(sharp, (150, 90), 6, (400.0, 380.0, 300.0), -1)
    exposures = [Exposure(t) for t in (0.002, 0.02, 0.2)]
    photographs = []
    for n, exposure in enumerate(exposures):
        shift = np.array([[1.0, 0.0, 0.5 * n], [0.0, 1.0, -0.3 * n]])
        photographs.append(raw(cv2.warpAffine(sharp, shift, (SIZE, SIZE)), exposure, f"p{n}.x", n))
    merged = merge_bracket(photographs, exposures, ON_BALL)
    assert merged.moved[ON_BALL].mean() < 0.01
    assert merged.image.radiance[90, 150].min() > 250.0


def test_counts_must_fit():
    photographs, exposures = bracket(raw, (0.05, 0.2))
    with pytest.raises(PhotographError, match="1 exposures for 2 photographs"):
        merge_bracket(photographs, exposures[:1], ON_BALL)


def test_a_black_bracket_is_merged_without_a_word_too_many():
    black = np.full((SIZE, SIZE, 3), 1e-7)
    merged = merge_bracket(*bracket(raw, (0.05, 0.2), black), ON_BALL)
    assert np.isnan(merged.offsets_ev).all()
    assert merged.warnings == ()
    assert np.isfinite(merged.image.radiance).all()


# ---------------------------------------------------------------- real photographs


def ball_crops(folder, names, circle, exposures_s=None):
    """Photographs of a tripod cut to the ball, and where it is."""
    x, y, radius = circle
    half = int(1.1 * radius)
    cut = np.s_[int(y) - half : int(y) + half, int(x) - half : int(x) + half]
    photographs = [read_photograph(folder / name) for name in names]
    photographs = [replace(p, pixels=p.pixels[cut], clipped=p.clipped[cut]) for p in photographs]
    rows, columns = np.mgrid[: 2 * half, : 2 * half]
    on_ball = np.hypot(rows - half, columns - half) < 0.95 * radius
    exposures = [Exposure(t) for t in exposures_s] if exposures_s else [p.exposure for p in photographs]
    return photographs, exposures, on_ball


def test_a_real_bracket_from_a_tripod_is_consistent(shared_dir):
    """Its author's exposures are right: 0.04 EV residual over the frame, 0.12 on the small ball (SOURCE.txt)."""
    folder = shared_dir / "photos/bracket_a6400_livingroom"
    merged = merge_bracket(*ball_crops(folder, [f"raw{n}.jpg" for n in (1, 2, 3)], (755.6, 549.5, 72.5)))
    assert merged.warnings == ()
    assert np.abs(merged.offsets_ev).max() < 0.1
    assert max(merged.response.residual_ev) < 0.12


def test_a_real_bracket_of_a_phone_is_consistent(shared_dir):
    folder = shared_dir / "photos/bracket_motog_library"
    names = [f"graingerBall_1_{n} copy.jpg" for n in (8, 30, 60, 90)]
    merged = merge_bracket(*ball_crops(folder, names, (2533, 2417, 186)))
    assert merged.warnings == ()
    assert np.abs(merged.offsets_ev).max() < 0.1
    assert max(merged.response.residual_ev) < 0.12


def test_the_duplicate_of_a_real_bracket_is_caught(shared_dir):
    folder = shared_dir / "photos/bad_bracket_duplicate"
    names, stated = ["Ball10.jpg", "Ball40.jpg", "Ball180.jpg"], (1 / 10, 1 / 40, 1 / 180)
    merged = merge_bracket(*ball_crops(folder, names, (374.0, 380.0, 335.0), stated))
    assert "Ball40.jpg and Ball180.jpg are the same exposure" in merged.warnings[0]
    relative = [e.relative for e in merged.exposures]
    assert np.log2(relative[2] / relative[1]) == pytest.approx(0.0, abs=0.1)
