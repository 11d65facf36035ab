import numpy as np
import pytest

from spectral_probe.errors import SpectralDataError
from spectral_probe.model import Edit, SpectralPanorama
from spectral_probe.spectra.basis import principal_components
from spectral_probe.spectra.colorimetry import colour_matching_functions, illuminant, panorama_xyz
from spectral_probe.spectra.edits import (
    MOST_BASES,
    apply_edit,
    edited_confidence,
    edited_mask,
    glass_edit,
    lamp_edit,
    lamp_spectrum,
    recovered_index,
    remove_all_edits,
    remove_edit,
    stacks_of,
)
from spectral_probe.spectra.glass import glass_transmittance
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.library import planck, surface_reflectances, training_lights

HEIGHT, WIDTH = 16, 32


def spectra_of(panorama):
    return np.einsum("hwk,hwkl->hwl", panorama.weights.astype(float), panorama.bases[panorama.basis_index])


@pytest.fixture(params=[(3, 1), (12, 2)], ids=["K3 B1", "K12 B2"])
def panorama(request):
    """Random mixtures of lights, K weights in B recovered bases."""
    weights_count, bases_count = request.param
    rng = np.random.default_rng(3)
    lights = training_lights(["incandescent", "daylight", "fluorescent-triband"])
    bases = np.stack([principal_components(lights[start:], weights_count) for start in range(bases_count)])
    index = rng.integers(0, bases_count, (HEIGHT, WIDTH)).astype(np.uint8)
    mixtures = rng.dirichlet(np.full(len(lights), 0.1), (HEIGHT, WIDTH)) @ lights
    weights = np.einsum("hwl,hwkl->hwk", mixtures, bases[index]).astype(np.float32)
    weights[0] = 0
    confidence = rng.random((HEIGHT, WIDTH)).astype(np.float32)
    valid = rng.random((HEIGHT, WIDTH)) < 0.9
    return SpectralPanorama(weights, bases, index, WAVELENGTHS_NM, valid, confidence, {"camera": "é"})


def box(rows, columns):
    mask = np.zeros((HEIGHT, WIDTH), bool)
    mask[rows, columns] = True
    return mask


LEFT, MIDDLE, RIGHT = (
    box(slice(4, 12), slice(0, 14)),
    box(slice(2, 8), slice(8, 20)),
    box(slice(6, 10), slice(12, 30)),
)


def same(a, b):
    assert a.weights is b.weights
    assert a.bases.tobytes() == b.bases.tobytes()
    assert a.basis_index.tobytes() == b.basis_index.tobytes()
    assert a.derived_bases == b.derived_bases
    assert a.confidence is b.confidence


def test_a_glass_multiplies_the_spectra_of_its_region(panorama):
    edited = apply_edit(panorama, glass_edit(panorama, "red", "left"), LEFT)
    before, after = spectra_of(panorama), spectra_of(edited)
    assert after[LEFT] == pytest.approx(before[LEFT] * glass_transmittance("red"), rel=1e-12, abs=1e-12)
    assert np.array_equal(after[~LEFT], before[~LEFT])
    assert [(edit.kind, edit.name, edit.region) for edit in edited.edits] == [("glass", "red", "left")]
    assert np.array_equal(edited_mask(edited, 0), LEFT)
    assert np.array_equal(edited_confidence(edited), panorama.confidence)


@pytest.mark.parametrize("keeps", ["luminance", "power"])
def test_a_lamp_takes_the_spectra_over_and_keeps_their_amount(panorama, keeps):
    edited = apply_edit(panorama, lamp_edit(panorama, "LED-B3", "left", keeps), LEFT)
    before, after = spectra_of(panorama), spectra_of(edited)
    led = illuminant("LED-B3")
    lit = LEFT & (before.sum(-1) > 1e-6)
    assert after[lit] / after[lit].sum(-1, keepdims=True) == pytest.approx(
        np.broadcast_to(led / led.sum(), after[lit].shape), rel=1e-9
    )
    if keeps == "luminance":
        kept = panorama_xyz(panorama)[..., 1], panorama_xyz(edited)[..., 1]
    else:
        kept = before.sum(-1), after.sum(-1)
    assert kept[1] == pytest.approx(kept[0], rel=1e-4, abs=1e-5)
    assert np.array_equal(after[~LEFT], before[~LEFT])
    assert (edited_confidence(edited)[LEFT] == 1).all()
    assert np.array_equal(edited_confidence(edited)[~LEFT], panorama.confidence[~LEFT])


def test_surfaces_keep_their_colours_under_another_lamp():
    surfaces = surface_reflectances()
    basis = principal_components(surfaces * illuminant("A"), 12)
    weights = (surfaces * illuminant("A") @ basis.T).astype(np.float32).reshape(4, 6, 12)
    whole = np.ones((4, 6), bool)
    panorama = SpectralPanorama(
        weights,
        basis[None],
        np.zeros((4, 6), np.uint8),
        WAVELENGTHS_NM,
        whole,
        np.full((4, 6), 0.5, np.float32),
    )
    edited = apply_edit(panorama, lamp_edit(panorama, "LED-B3", "all", "surfaces", "A"), whole)
    led = illuminant("LED-B3")
    matching = colour_matching_functions()[:, 1]
    expected = surfaces * led * (illuminant("A") @ matching / (led @ matching))
    assert spectra_of(edited).reshape(24, 61) == pytest.approx(expected, rel=0.03, abs=0.02 * expected.max())
    assert edited.edits[0].name == "LED-B3 for A"
    assert (edited_confidence(edited) == np.float32(0.5)).all()
    same(remove_edit(edited, 0), panorama)


def test_no_edit_makes_light_negative(panorama):
    floor = min(spectra_of(panorama).min(), 0.0)
    for edit in (glass_edit(panorama, "yellow", ""), lamp_edit(panorama, "FL11", "")):
        assert spectra_of(apply_edit(panorama, edit, LEFT)).min() >= floor - 1e-9


def stacked(panorama):
    for mask, edit in (
        (LEFT, glass_edit(panorama, "red", "left")),
        (MIDDLE, lamp_edit(panorama, "LED-B3", "middle")),
        (RIGHT, glass_edit(panorama, "green", "right")),
    ):
        panorama = apply_edit(panorama, edit, mask)
    return panorama


def test_overlapping_edits_are_done_in_order(panorama):
    edited = stacked(panorama)
    both = LEFT & MIDDLE & RIGHT
    assert both.any()
    before, after = spectra_of(panorama)[both], spectra_of(edited)[both]
    red = before * glass_transmittance("red")
    matching = colour_matching_functions()[:, 1]
    led = illuminant("LED-B3")
    expected = np.outer(red @ matching, led / (led @ matching)) * glass_transmittance("green")
    assert after == pytest.approx(expected, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("number", [0, 1, 2])
def test_one_edit_taken_back_leaves_what_the_others_would_have_made(panorama, number):
    others = [
        (LEFT, glass_edit(panorama, "red", "left")),
        (MIDDLE, lamp_edit(panorama, "LED-B3", "middle")),
        (RIGHT, glass_edit(panorama, "green", "right")),
    ]
    del others[number]
    expected = panorama
    for mask, edit in others:
        expected = apply_edit(expected, edit, mask)
    left = remove_edit(stacked(panorama), number)
    assert [edit.region for edit in left.edits] == [edit.region for edit in expected.edits]
    assert np.array_equal(spectra_of(left), spectra_of(expected))
    assert sorted(left.derived_bases) == sorted(expected.derived_bases)


@pytest.mark.parametrize("order", [(0, 0, 0), (2, 1, 0), (1, 1, 0)])
def test_all_taken_back_in_any_order_is_the_original_to_the_bit(panorama, order):
    edited = stacked(panorama)
    for number in order:
        edited = remove_edit(edited, number)
    same(edited, panorama)
    same(remove_all_edits(stacked(panorama)), panorama)
    assert edited.edits == ()


def test_where_the_weights_came_from_is_not_forgotten(panorama):
    edited = stacked(panorama)
    assert np.array_equal(recovered_index(edited), panorama.basis_index)
    assert len(stacks_of(edited)) == len(edited.bases)


def test_as_many_bases_as_can_be_told_apart(panorama):
    edited = panorama
    edit = Edit("glass", "grey", "one texel", np.full(61, 0.5))
    for number in range(MOST_BASES - len(panorama.bases)):  # one texel each time, one basis more
        edited = apply_edit(edited, edit, box(number // WIDTH, number % WIDTH))
    assert len(edited.bases) == MOST_BASES
    with pytest.raises(SpectralDataError, match=f"a probe holds {MOST_BASES}. Remove an edit first"):
        apply_edit(edited, edit, box(-1, -1))
    same(remove_all_edits(edited), panorama)


def test_bad_edits(panorama, tmp_path):
    red = glass_edit(panorama, "red", "nowhere")
    with pytest.raises(SpectralDataError, match=r"\(nowhere\) selects nothing"):
        apply_edit(panorama, red, np.zeros_like(LEFT))
    with pytest.raises(SpectralDataError, match="has no edit 1: it has none"):
        remove_edit(panorama, 0)
    with pytest.raises(SpectralDataError, match="has no edit 2: it has 1, counted from 1"):
        remove_edit(apply_edit(panorama, red, LEFT), 1)
    with pytest.raises(SpectralDataError, match="LED-B33"):
        lamp_edit(panorama, "LED-B33", "left")
    with pytest.raises(SpectralDataError, match="Say which lamp it was"):
        lamp_edit(panorama, "LED-B3", "left", "surfaces")
    with pytest.raises(SpectralDataError, match="The lamp LPS gives no light at 400 nm"):
        lamp_edit(panorama, "LED-B3", "left", "surfaces", "LPS")
    with pytest.raises(SpectralDataError, match=r"There is no file lost\.csv"):
        lamp_edit(panorama, "lost.csv", "left")
    rows = [f"{nm:g},{-1 if nm == 500 else 1}" for nm in WAVELENGTHS_NM]
    (tmp_path / "dark.csv").write_text("nm,power\n" + "\n".join(rows))
    with pytest.raises(SpectralDataError, match=r"dark\.csv has negative power"):
        lamp_edit(panorama, tmp_path / "dark.csv", "left")
    (tmp_path / "zero.csv").write_text("nm,power\n400,0\n700,0\n")
    with pytest.raises(SpectralDataError, match="gives no light that is seen"):
        lamp_edit(panorama, tmp_path / "zero.csv", "left")


def test_a_lamp_of_ones_own(tmp_path):
    rows = [f"{nm:g},{value:.9g}" for nm, value in zip(WAVELENGTHS_NM, planck(3000.0), strict=True)]
    (tmp_path / "lamp.csv").write_text("nm,power\n" + "\n".join(rows))
    assert lamp_spectrum(tmp_path / "lamp.csv") == pytest.approx(planck(3000.0), rel=1e-6)
    assert lamp_spectrum("Planck 3000 K") == pytest.approx(planck(3000.0))
