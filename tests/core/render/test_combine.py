"""Passes to tristimulus values and spectra."""

import numpy as np
import pytest

from spectral_probe.errors import RenderError
from spectral_probe.render.combine import combine_spectrum, combine_xyz
from spectral_probe.render.plan import reference_plan
from spectral_probe.render_model import PassPlan
from spectral_probe.spectra.colorimetry import illuminant, spectra_to_xyz
from spectral_probe.spectra.grid import WAVELENGTHS_NM


def passes_of(plan, spectra):
    """What a perfect renderer returns for an image (H, W, 61) in a wavelength plan."""
    for wavelengths in plan.wavelengths_nm:
        yield np.stack([spectra[..., np.searchsorted(WAVELENGTHS_NM, nm)] for nm in wavelengths], -1)


def test_the_reference_gives_back_spectra_and_their_tristimulus_values():
    spectra = np.random.default_rng(1).random((4, 6, 61)).astype(np.float32)
    plan = reference_plan()
    np.testing.assert_allclose(combine_spectrum(plan, passes_of(plan, spectra)), spectra, rtol=1e-6)
    np.testing.assert_allclose(
        combine_xyz(plan, passes_of(plan, spectra)), spectra_to_xyz(spectra), rtol=1e-5
    )


def test_a_light_basis_plan_puts_the_light_back():
    layers = np.stack([illuminant(name) / 100 for name in ("A", "D65", "FL2")])
    interpolation = np.random.default_rng(4).dirichlet(np.ones(3), size=61).T  # keeps constants
    plan = PassPlan(
        kind="light-basis",
        wavelengths_nm=np.repeat([[450.0], [550.0], [610.0]], 3, axis=1),
        reconstruction=interpolation[:, None] * layers,
        grid_nm=WAVELENGTHS_NM.copy(),
        sample_shares=np.ones(3),
        references=(0, 1, 2),
        light_sets=(0, 0, 0),
        interpolation=interpolation,
    )
    weights = np.random.default_rng(2).random((5, 7, 3))
    spectra = combine_spectrum(
        plan, [weights] * 3
    )  # nothing between lamp and camera depends on the wavelength
    np.testing.assert_allclose(spectra, weights @ layers, rtol=1e-5)
    np.testing.assert_allclose(combine_xyz(plan, [weights] * 3), spectra_to_xyz(weights @ layers), rtol=1e-5)


def test_passes_are_read_one_at_a_time():
    plan = reference_plan()
    alive = 0

    def images():
        nonlocal alive
        for _ in range(plan.passes):
            alive += 1
            yield np.ones((2, 2, 3))
            alive -= 1

    assert combine_xyz(plan, images()).shape == (2, 2, 3)
    assert alive <= 1


@pytest.mark.parametrize(
    ("count", "message"), [(0, "0 of 21"), (20, "20 of 21"), (22, "more passes than the 21")]
)
def test_a_wrong_number_of_passes_is_refused(count, message):
    with pytest.raises(RenderError, match=message):
        combine_xyz(reference_plan(), [np.zeros((1, 1, 3))] * count)


def test_passes_of_different_sizes_are_refused():
    images = [np.zeros((1, 1, 3))] * 20 + [np.zeros((2, 1, 3))]
    with pytest.raises(RenderError, match="differ in size"):
        combine_xyz(reference_plan(), images)
