"""Light sets: as few as hold the light within the bound, disjoint, complete; regions with layers of their own."""

import numpy as np
import pytest

from spectral_probe.errors import RenderError
from spectral_probe.model import SpectralPanorama
from spectral_probe.render.light_samples import largest_error, light_samples, random_picture
from spectral_probe.render.light_sets import LAYERS_SHARE, light_rank, light_sets
from spectral_probe.render.plan import describe, make_plan
from spectral_probe.spectra.colorimetry import delta_e_2000, illuminant, spectra_to_xyz, white_xyz
from spectral_probe.spectra.edits import apply_edit, glass_edit, lamp_edit
from spectral_probe.spectra.glass import glass_transmittance
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.library import daylight, planck, surface_reflectances

H, W = 24, 48


def panorama(weights, bases):
    return SpectralPanorama(
        weights=np.asarray(weights, np.float32),
        bases=np.asarray(bases, float)[None],
        basis_index=np.zeros((H, W), np.uint8),
        wavelengths_nm=WAVELENGTHS_NM.copy(),
        valid=np.ones((H, W), bool),
        confidence=np.ones((H, W), np.float32),
    )


def box(rows, columns):
    mask = np.zeros((H, W), bool)
    mask[slice(*rows), slice(*columns)] = True
    return mask


WINDOW, LAMP, DOOR = box((6, 12), (4, 10)), box((6, 12), (20, 26)), box((12, 18), (36, 40))


@pytest.fixture(scope="module")
def surfaces():
    return surface_reflectances()


@pytest.fixture(scope="module")
def room():
    """Daylight and tungsten everywhere, windows of mixed daylight, a desk lamp of one spectrum."""
    generator = np.random.default_rng(1)
    weights = 0.1 * generator.random((H, W, 3)) * np.array([1.0, 1.0, 0.0])
    weights[WINDOW] = 10 * generator.random((36, 3)) * np.array([1.0, 0.2, 0.0])
    weights[LAMP] = 20 * generator.random((36, 1)) * np.array([0.0, 0.0, 1.0])
    return panorama(weights, [daylight(6500), planck(2856.0), illuminant("FL11") / 10])


@pytest.fixture(scope="module")
def tubes():
    """Seven kinds of light in vertical stripes, spiky ones among them: three layers cannot hold them."""
    kinds = ("A", "D65", "FL2", "FL11", "HP1", "LED-B3", "LED-RGB1")
    spectra = np.stack([illuminant(name) for name in kinds])
    weights = np.zeros((H, W, len(kinds)))
    weights[:, np.arange(W), np.arange(W) * len(kinds) // W] = 1.0
    return panorama(weights, spectra / spectra.mean(-1, keepdims=True))


def spectra_of(probe):
    return np.einsum("hwk,hwkl->hwl", probe.weights.astype(float), probe.bases[probe.basis_index])


def held_by(sets):
    return sum(light.layers.weights.astype(float) @ light.layers.spectra for light in sets)


def test_three_layers_hold_two_kinds_of_light(room, surfaces):
    sets = light_sets(room, reflectances=surfaces, max_de2000=0.5)
    assert len(sets) == 1
    assert light_rank(room) == 3
    np.testing.assert_allclose(held_by(sets), spectra_of(room), atol=2e-3 * spectra_of(room).max())


def test_more_kinds_are_split_by_direction_until_the_bound_holds(tubes, surfaces):
    assert light_rank(tubes) == 7
    sets = light_sets(tubes, reflectances=surfaces, max_de2000=0.5)
    assert 2 <= len(sets) <= 4
    holding = sum((light.layers.weights > 0).any(-1).astype(int) for light in sets)
    assert (holding == 1).all()  # each direction in one set
    picture = random_picture(tubes, sets, surfaces, seed=99)
    one = light_sets(tubes, reflectances=surfaces, max_de2000=1e3)
    assert len(one) == 1
    held = largest_error(picture.layers_errors(sets))
    in_one = largest_error(random_picture(tubes, one, surfaces, seed=99).layers_errors(one))
    assert held < 1.5 * LAYERS_SHARE * 0.5 < in_one  # other pixels than the choice was made with
    true, ours = spectra_to_xyz(spectra_of(tubes)), spectra_to_xyz(held_by(sets))
    assert delta_e_2000(true, ours, white_xyz() * true[..., 1].mean()).max() < 0.1


def test_grey_surfaces_need_no_more_sets(tubes):
    """Direct light keeps its colour in three layers: without coloured surfaces nothing else is seen."""
    assert len(light_sets(tubes, reflectances=np.full((1, 61), 0.5), max_de2000=0.5)) == 1


def test_the_plan_says_the_rank_and_the_sets(tubes, surfaces):
    sets = light_sets(tubes, reflectances=surfaces, max_de2000=0.5)
    plan = make_plan(sets, tubes, surfaces, passes=6, samples=128)
    assert set(plan.light_sets) == set(range(len(sets)))
    full = plan.sample_shares[sorted(set(plan.references))]
    np.testing.assert_allclose(full.sum(), 1.0)
    assert full.min() >= 0.25 - 1e-9
    for number, reference in enumerate(plan.references):
        assert plan.light_sets[reference] == plan.light_sets[number]
    assert any("7 kinds of spectrum" in sentence and "split into" in sentence for sentence in describe(plan))


def test_lights_are_drawn_from_the_panorama(room):
    sets = light_sets(room, reflectances=np.ones((1, 61)), max_de2000=0.5)
    samples = light_samples(room, sets, 500, seed=3)
    np.testing.assert_allclose(spectra_to_xyz(samples.spectra)[:, 1], 1.0)
    held = np.einsum("ngc,gcl->nl", samples.held, np.stack([light.layers.spectra for light in sets]))
    np.testing.assert_allclose(held, samples.spectra, atol=2e-3 * samples.spectra.max())


# ---------------------------------------------------------------- swappable regions


def test_a_lamp_takes_one_layer_and_a_window_more(room, surfaces):
    sets = light_sets(room, swappable={"desk": LAMP, "window": WINDOW}, reflectances=surfaces, max_de2000=0.5)
    assert [light.swappable for light in sets] == [("", "", ""), ("window", "window", "desk")]
    assert (sets[0].layers.weights[LAMP | WINDOW] == 0).all()
    assert (sets[1].layers.weights[~(LAMP | WINDOW)] == 0).all()
    np.testing.assert_allclose(held_by(sets), spectra_of(room), atol=5e-3 * spectra_of(room).max())
    plan = make_plan(sets, room, surfaces, passes=5)
    assert [(layer.name, layer.light_set, layer.channel) for layer in plan.swappable] == [
        ("window", 1, 0),
        ("window", 1, 1),
        ("desk", 1, 2),
    ]
    without = make_plan(sets[:1], room, surfaces, passes=5).predicted_cost
    assert plan.predicted_cost > without
    assert any(
        f"cost {plan.predicted_cost - without:.2f} RGB renders more" in note for note in describe(plan)
    )


def test_a_region_behind_glass_keeps_its_own_light(room, surfaces):
    stained = apply_edit(room, glass_edit(room, "red", "window"), WINDOW)
    sets = light_sets(stained, swappable={"window": WINDOW}, reflectances=surfaces, max_de2000=0.5)
    light = sets[1]
    used = [channel for channel, name in enumerate(light.swappable) if name]
    red = glass_transmittance("red")
    np.testing.assert_allclose(light.layers.spectra[used], light.recovered_spectra[used] * red)
    again = light.layers.weights.astype(float) @ light.recovered_spectra
    np.testing.assert_allclose(again[WINDOW], spectra_of(room)[WINDOW], atol=5e-3 * spectra_of(room).max())


def test_glass_under_another_lamp_is_not_behind(room, surfaces):
    """The lamp was replaced after the glass: what a further glass filters is the lamp."""
    edited = apply_edit(room, glass_edit(room, "red", "window"), WINDOW)
    edited = apply_edit(edited, lamp_edit(edited, "A", "window"), WINDOW)
    light = light_sets(edited, swappable={"window": WINDOW}, reflectances=surfaces, max_de2000=0.5)[1]
    assert light.swappable == ("window", "", "")
    np.testing.assert_allclose(light.recovered_spectra, light.layers.spectra)
    ratio = light.layers.spectra[0] / illuminant("A")
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-3)


def test_parts_under_different_glass_stay_as_they_are(room, surfaces):
    half = WINDOW & box((0, H), (0, 7))
    edited = apply_edit(room, glass_edit(room, "red", "half"), half)
    light = light_sets(edited, swappable={"window": WINDOW}, reflectances=surfaces, max_de2000=0.5)[1]
    np.testing.assert_allclose(light.recovered_spectra, light.layers.spectra)


def test_a_region_within_another_or_black_is_refused(room, surfaces):
    for regions in ({"all": WINDOW, "part": box((7, 8), (5, 6))}, {"nothing": np.zeros((H, W), bool)}):
        with pytest.raises(RenderError, match="holds no light, or lies within another"):
            light_sets(room, swappable=regions, reflectances=surfaces, max_de2000=0.5)


def test_where_regions_hold_all_light_set_0_is_black(room, surfaces):
    everything = np.ones((H, W), bool)
    sets = light_sets(room, swappable={"all": everything}, reflectances=surfaces, max_de2000=0.5)
    assert (sets[0].layers.weights == 0).all()
    plan = make_plan(sets, room, surfaces, passes=4)
    assert np.isfinite(plan.sample_shares).all()
