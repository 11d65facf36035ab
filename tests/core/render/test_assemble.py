"""Steps of a render put together: both kinds of plan, light groups, swappable layers."""

from dataclasses import replace

import numpy as np
import pytest

from spectral_probe.errors import RenderError
from spectral_probe.render.assemble import assemble, rendered_wavelengths_nm
from spectral_probe.render.pass_folder import render_steps
from spectral_probe.render.plan import reference_plan
from spectral_probe.render_model import (
    WORLD,
    EmissionGroup,
    PassImage,
    PassPlan,
    RenderStep,
    SwappableLayer,
)
from spectral_probe.spectra.colorimetry import illuminant, spectra_to_xyz
from spectral_probe.spectra.grid import WAVELENGTHS_NM

NODES_NM = np.array([450.0, 550.0, 650.0])
FULL, FEW = 32, 4
LAYERS = np.stack([illuminant("A"), illuminant("D65"), illuminant("FL2")]) / 100


def light_basis_plan(**changes: object) -> PassPlan:
    """Three wavelengths, linear interpolation; 550 nm is the reference."""
    weights = np.stack([np.interp(WAVELENGTHS_NM, NODES_NM, unit) for unit in np.eye(3)])
    plan = PassPlan(
        kind="light-basis",
        wavelengths_nm=np.repeat(NODES_NM[:, None], 3, axis=1),
        reconstruction=weights[:, None, :] * LAYERS[None],
        grid_nm=WAVELENGTHS_NM,
        sample_shares=np.array([FEW / FULL, 1.0, FEW / FULL]),
        references=(1, 1, 1),
        light_sets=(0, 0, 0),
        interpolation=weights,
    )
    return replace(plan, **changes)  # type: ignore[arg-type]


STEPS = (
    RenderStep("pass_01_head", 1, 0, FEW, guide=True),
    RenderStep("pass_01_tail", 1, FEW, FULL - FEW),
    RenderStep("pass_00", 0, 0, FEW),
    RenderStep("pass_02", 2, 0, FEW),
)
TRANSPORT = {0: 0.2, 1: 0.5, 2: 0.8}


def flat(step: RenderStep) -> PassImage:
    """A grey surface of reflectance TRANSPORT under all three layers."""
    return PassImage({WORLD: np.full((6, 8, 3), TRANSPORT[step.pass_number], np.float32)})


def expected_spectrum() -> np.ndarray:
    reflectance = np.interp(WAVELENGTHS_NM, NODES_NM, [0.2, 0.5, 0.8])
    return np.asarray(reflectance * LAYERS.sum(0))


def test_light_basis_passes_become_xyz_and_bands() -> None:
    plan = light_basis_plan()
    assembled = assemble(plan, STEPS, flat, bands_nm=rendered_wavelengths_nm(plan))
    spectrum = expected_spectrum()
    np.testing.assert_allclose(assembled.xyz[3, 4], spectra_to_xyz(spectrum), rtol=2e-3)
    assert assembled.xyz.dtype == np.float32
    assert assembled.bands is not None
    at_nodes = spectrum[np.searchsorted(WAVELENGTHS_NM, NODES_NM)]
    np.testing.assert_allclose(assembled.bands[:, 3, 4], at_nodes, rtol=3e-3)
    assert assembled.alpha is None


def test_each_step_is_read_once_and_its_image_released() -> None:
    read: list[str] = []

    def counted(step: RenderStep) -> PassImage:
        read.append(step.name)
        return flat(step)

    assemble(light_basis_plan(), STEPS, counted)
    assert sorted(read) == sorted(step.name for step in STEPS)


def test_head_and_tail_weigh_by_their_samples() -> None:
    plan = light_basis_plan(references=(0, 1, 2))
    steps = (*STEPS[:2], RenderStep("pass_00", 0, 0, FULL), RenderStep("pass_02", 2, 0, FULL))

    def read(step: RenderStep) -> PassImage:
        image = np.full((2, 2, 3), 8.0 if step.name.endswith("head") else 0.0, np.float32)
        return PassImage({WORLD: image}, alpha=image[..., 0] / 8)

    assembled = assemble(plan, steps, read, bands_nm=np.array([550.0]))
    assert assembled.bands is not None
    at_550 = LAYERS.sum(0)[30] * 8.0 * FEW / FULL
    assert assembled.bands[0, 0, 0] == pytest.approx(at_550, rel=1e-5)


def test_wavelength_plan_is_the_same_sum() -> None:
    plan = reference_plan()
    steps = [RenderStep(f"pass_{p:02d}", p, 0, 4) for p in range(plan.passes)]
    spectrum = illuminant("FL11")
    index = np.searchsorted(WAVELENGTHS_NM, plan.wavelengths_nm)

    def read(step: RenderStep) -> PassImage:
        channels = spectrum[index[step.pass_number]].astype(np.float32)
        return PassImage({WORLD: np.broadcast_to(channels, (2, 3, 3))})

    assembled = assemble(plan, steps, read, bands_nm=WAVELENGTHS_NM)
    assert assembled.bands is not None
    np.testing.assert_allclose(assembled.bands[:, 1, 2], spectrum, rtol=1e-5)
    np.testing.assert_allclose(assembled.xyz[1, 2], spectra_to_xyz(spectrum), rtol=1e-5)


def with_lamps(step: RenderStep) -> PassImage:
    world = flat(step).groups[WORLD]
    lamps = np.zeros_like(world)
    lamps[..., 1] = 2.0 * TRANSPORT[step.pass_number]
    return PassImage({WORLD: world, "lamps 1": lamps}, alpha=np.full((6, 8), 0.5, np.float32))


def test_lamps_add_their_own_spectra() -> None:
    lamp = EmissionGroup("lamps 1", np.stack([illuminant(name) for name in ("A", "FL11", "HP1")]))
    assembled = assemble(light_basis_plan(emission=(lamp,)), STEPS, with_lamps)
    reflectance = np.interp(WAVELENGTHS_NM, NODES_NM, [0.2, 0.5, 0.8])
    expected = expected_spectrum() + 2.0 * reflectance * illuminant("FL11")
    np.testing.assert_allclose(assembled.xyz[0, 0], spectra_to_xyz(expected), rtol=2e-3)
    assert assembled.alpha is not None
    assert assembled.alpha[0, 0] == 0.5


def test_swappable_layers_add_up_to_the_whole() -> None:
    lamp = EmissionGroup(
        "lamps 1", np.stack([illuminant(name) for name in ("A", "FL11", "HP1")]), ("", "Desk", "")
    )
    window = SwappableLayer("Window", 0, 2, LAYERS[2])
    plan = light_basis_plan(emission=(lamp,), swappable=(window,))
    assembled = assemble(plan, STEPS, with_lamps)
    planes = assembled.swappable
    layers = {f"layer{layer}.pass{number}" for layer in range(2) for number in range(3)}
    assert set(planes) == {"fixed.X", "fixed.Y", "fixed.Z"} | layers
    total = np.stack([planes[f"fixed.{name}"] for name in "XYZ"], axis=-1)
    assert plan.interpolation is not None
    for layer, spectrum in enumerate((LAYERS[2], illuminant("FL11"))):
        for number in range(3):
            own = spectra_to_xyz(plan.interpolation[number] * spectrum)
            total = total + planes[f"layer{layer}.pass{number}"][..., None] * own
    np.testing.assert_allclose(total, assembled.xyz, rtol=1e-4)


def test_missing_and_unfit_steps_are_named() -> None:
    plan = light_basis_plan()
    with pytest.raises(RenderError, match="1 of 3 passes"):
        assemble(plan, STEPS[:-1], flat)
    with pytest.raises(RenderError, match="other samples"):
        assemble(plan, (*STEPS[:-1], RenderStep("pass_02", 2, 0, FEW + 1)), flat)

    def cropped(step: RenderStep) -> PassImage:
        size = 3 if step.pass_number == 2 else 6
        return PassImage({WORLD: np.ones((size, 8, 3), np.float32)})

    with pytest.raises(RenderError, match="differ in size"):
        assemble(plan, STEPS, cropped)
    with pytest.raises(RenderError, match="not in the plan"):
        assemble(plan, STEPS, with_lamps)


@pytest.mark.parametrize("everywhere", [True, False])
def test_the_guide_has_the_colour_of_all_passes(everywhere: bool) -> None:
    def read(step: RenderStep) -> PassImage:
        guide = np.zeros((6, 8, 7), np.float32)
        guide[..., :3], guide[..., 5] = TRANSPORT[step.pass_number], 1.0
        return PassImage(flat(step).groups, guide=guide if everywhere or step.guide else None)

    assembled = assemble(light_basis_plan(), STEPS, read)
    assert assembled.guide is not None
    reflectance = np.interp(WAVELENGTHS_NM, NODES_NM, [0.2, 0.5, 0.8])
    colour = spectra_to_xyz(reflectance) / spectra_to_xyz(np.ones(61)) if everywhere else [0.5] * 3
    np.testing.assert_allclose(assembled.guide[2, 3, :3], colour, rtol=1e-5)
    assert assembled.guide[2, 3, 5] == 1.0


def test_alpha_is_that_of_all_samples():
    """Passes that share the samples of one render see edges through samples of their own."""
    plan = replace(reference_plan(), consecutive=True)
    steps = render_steps(plan, 50)

    def read(step: RenderStep) -> PassImage:
        alpha = np.full((2, 2), float(step.pass_number == 0), np.float32)
        return PassImage({WORLD: np.ones((2, 2, 3), np.float32)}, alpha=alpha)

    alpha = assemble(plan, steps, read).alpha
    np.testing.assert_allclose(alpha, steps[0].samples / 50, rtol=1e-6)
