"""Plans of Cycles passes: which wavelengths to render, and how the passes become spectra.

Two kinds, both put together by one sum (`PassPlan`):

- **wavelength**: each channel holds light and materials at one wavelength; 21 passes are the 61-sample reference.
- **light-basis**: the world's channels hold three light layers, each pass sets all materials to one wavelength. What
  the scene does with light between lamp and camera (its transport) is smooth in wavelength even where the light is
  not, so a few wavelengths and an interpolation hold it, and the light enters at full resolution afterwards.

The interpolation is made for the scene at hand. Transport is a sum of products of the scene's own reflectances, so
the covariance of random products of them says how its value at one wavelength follows from its values at others
(best linear prediction under the constraint that constants are kept: ordinary kriging; Cressie, Statistics for
Spatial Data, 1993, sect. 3.2). The wavelengths are chosen one after another, and then exchanged one by one, to make the
expected error in a linearised CIELAB smallest.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..errors import FileFormatError, RenderError
from ..files.atomic import written_whole
from ..model import FloatArray
from ..render_model import PassPlan
from ..spectra.colorimetry import colour_matching_functions, delta_e_2000, spectra_to_xyz
from ..spectra.grid import STEP_NM, WAVELENGTHS_NM

TARGET_MEAN_DE2000 = 0.25
"""Predicted mean colour error that the automatic number of passes must reach."""

TARGET_MAX_DE2000 = 2.0
"""Predicted error of the worst of the random colours that the automatic number of passes must reach."""

FEWEST_PASSES, MOST_PASSES = 3, 20

_TRAINING, _HELD_OUT = 4000, 2000
_LIGHTS_IN_METRIC = 64
_NUGGET = 1e-6
"""Share of the mean variance added on the diagonal: keeps the interpolation from amplifying noise."""

_FORMAT = "spectral-probe-plan-1"


def reference_plan() -> PassPlan:
    """The 61-wavelength reference in 21 passes, wavelengths far apart sharing a pass.

    61 samples fill 63 channels: the last two repeat 700 nm and contribute nothing.

    Examples
    --------
    >>> plan = reference_plan()
    >>> plan.passes, float(plan.reconstruction.sum())
    (21, 61.0)
    """
    count = len(WAVELENGTHS_NM)
    passes = -(-count // 3)
    index = np.arange(passes)[:, None] + passes * np.arange(3)
    reconstruction = np.zeros((passes, 3, count))
    real = index < count
    reconstruction[(*np.nonzero(real), index[real])] = 1.0
    return PassPlan(
        kind="wavelength",
        wavelengths_nm=WAVELENGTHS_NM[np.minimum(index, count - 1)],
        reconstruction=reconstruction,
        grid_nm=WAVELENGTHS_NM.copy(),
        sample_shares=np.ones(passes),
        references=tuple(range(passes)),
        light_sets=(0,) * passes,
        predicted_cost=float(passes),
    )


def light_basis_plan(
    layer_spectra: FloatArray,
    material_spectra: FloatArray,
    passes: int | None = None,
    mixtures: FloatArray | None = None,
) -> PassPlan:
    """A plan that renders the scene's transport of three light layers at few wavelengths.

    Parameters
    ----------
    layer_spectra
        (3, 61) spectra of the light layers, may be signed.
    material_spectra
        (N, 61) reflectances of the scene's materials, metals at several incidence angles. A constant is
        always added (light seen directly, white surfaces).
    passes
        Number of wavelengths; None takes the fewest that reach `TARGET_MEAN_DE2000` and `TARGET_MAX_DE2000`.
    mixtures
        (M, 3) shares of the layers in the light that occurs (`layers.light_mixtures`); a layer alone may be no light at all,
        since its spectrum may be signed. None takes all mixtures alike.

    Returns
    -------
    PassPlan
        With the predicted mean and maximum dE2000 against all 61 wavelengths, over random held-out products of
        up to three reflectances under the mixtures of the layers, the white being that of the mean mixture.

    Raises
    ------
    RenderError
        If the number of passes is not in 1..61.

    Examples
    --------
    >>> plan = light_basis_plan(np.ones((3, 61)), np.linspace(0.1, 0.9, 61)[None], passes=4)
    >>> plan.passes, bool(np.allclose(plan.reconstruction.sum((0, 1)), 3.0))
    (4, True)
    """
    count = len(WAVELENGTHS_NM)
    if passes is not None and not 1 <= passes <= count:
        raise RenderError(
            f"{passes} passes were asked for; choose a number from 1 to {count}, or all wavelengths."
        )
    layers = np.asarray(layer_spectra, float)
    surfaces = np.concatenate([np.ones((1, count)), np.asarray(material_spectra, float).reshape(-1, count)])
    training = _random_transport(surfaces, _TRAINING, seed=1)
    covariance = training.T @ training / len(training)
    covariance += _NUGGET * np.trace(covariance) / count * np.eye(count)
    lights = _lights(layers, mixtures)
    metric = _lab_metric(lights)
    held_out = _random_transport(surfaces, _HELD_OUT, seed=2)

    nodes: list[int] = []
    for size in range(1, (passes or MOST_PASSES) + 1):
        nodes = _exchange(_add_node(nodes, covariance, metric), covariance, metric)
        if size < (passes or FEWEST_PASSES):
            continue
        weights = _interpolation(sorted(nodes), covariance)
        plan = _plan_of(sorted(nodes), weights, layers)
        predicted = _predicted_error(plan, weights, lights, held_out)
        if size == passes or (predicted[0] <= TARGET_MEAN_DE2000 and predicted[1] <= TARGET_MAX_DE2000):
            break
    return replace(plan, predicted_de2000=predicted)


def _random_transport(surfaces: FloatArray, count: int, seed: int) -> FloatArray:
    """Random sums of one or two products of one to three reflectances, (count, L), each with mean 1."""
    generator = np.random.default_rng(seed)
    transport = np.zeros((count, surfaces.shape[1]))
    for _ in range(2):
        factors = surfaces[generator.integers(len(surfaces), size=(count, 3))]
        bounces = generator.integers(1, 4, size=count)
        factors[np.arange(3) >= bounces[:, None]] = 1.0
        product = factors.prod(1)
        # The second product is left out half the time, so that pure products are as common as sums.
        share = (
            generator.random((count, 1)) * (generator.random((count, 1)) < 0.5) if transport.any() else 1.0
        )
        transport += share * product / np.maximum(product.mean(1, keepdims=True), 1e-6)
    return transport / np.maximum(transport.mean(1, keepdims=True), 1e-6)


def _lights(layers: FloatArray, mixtures: FloatArray | None) -> FloatArray:
    """Lights (M, L) that occur: mixtures of the layers, each as bright as their mean; those no eye can see are left out."""
    if mixtures is None:
        mixtures = np.random.default_rng(3).dirichlet(np.ones(len(layers)), size=_HELD_OUT)
    lights = np.concatenate([mixtures.mean(0, keepdims=True), mixtures]) @ layers
    xyz = spectra_to_xyz(lights)
    seen = (xyz > 1e-3 * xyz[:, 1:2]).all(-1) & (xyz[:, 1] > 0)
    return np.asarray(lights[seen] / xyz[seen, 1:2])


def _lab_metric(lights: FloatArray) -> FloatArray:
    """(L, L) matrix G: the squared error of a transport e (L,) in linearised CIELAB is e G e, in the mean over the lights.

    The white is the first of the lights.
    """
    cmf = colour_matching_functions() * STEP_NM
    white = spectra_to_xyz(lights[0])
    to_lab = np.array([[0.0, 116.0, 0.0], [500.0, -500.0, 0.0], [0.0, 200.0, -200.0]]) / 3.0
    metric = np.zeros((lights.shape[1],) * 2)
    for light in lights[: _LIGHTS_IN_METRIC + 1]:
        sensitivity = (light[:, None] * cmf / white) @ to_lab.T
        metric += sensitivity @ sensitivity.T
    return metric


def _interpolation(nodes: Sequence[int], covariance: FloatArray) -> FloatArray:
    """(P, L) weights by which values at the nodes predict those at every wavelength; columns sum to one."""
    size = len(nodes)
    system = np.ones((size + 1, size + 1))
    system[size, size] = 0.0
    system[:size, :size] = covariance[np.ix_(nodes, nodes)]
    target = np.concatenate([covariance[list(nodes)], np.ones((1, covariance.shape[1]))])
    weights: FloatArray = np.linalg.solve(system, target)[:size]
    weights[:, list(nodes)] = np.eye(size)  # the nugget would blur what is known exactly
    return weights


def _expected_error(nodes: Sequence[int], covariance: FloatArray, metric: FloatArray) -> float:
    """Expected squared error of the interpolation, up to a constant: E[e G e] for e = t - W t_nodes."""
    weights = _interpolation(nodes, covariance)
    weighed = weights @ metric
    explained = (weighed * covariance[list(nodes)]).sum()
    return float((weighed @ weights.T * covariance[np.ix_(nodes, nodes)]).sum() - 2.0 * explained)


def _add_node(nodes: list[int], covariance: FloatArray, metric: FloatArray) -> list[int]:
    free = [i for i in range(len(covariance)) if i not in nodes]
    return [*nodes, min(free, key=lambda i: _expected_error([*nodes, i], covariance, metric))]


def _exchange(nodes: list[int], covariance: FloatArray, metric: FloatArray) -> list[int]:
    """Move each node in turn to where the error is smallest, once round; never makes the error larger."""
    if len(nodes) == len(covariance):
        return nodes
    for position in range(len(nodes)):
        others = nodes[:position] + nodes[position + 1 :]
        nodes = _add_node(others, covariance, metric)
        nodes.insert(position, nodes.pop())
    return nodes


def _plan_of(nodes: list[int], weights: FloatArray, layers: FloatArray) -> PassPlan:
    return PassPlan(
        kind="light-basis",
        wavelengths_nm=np.repeat(WAVELENGTHS_NM[nodes][:, None], 3, axis=1),
        reconstruction=weights[:, None, :] * layers[None],
        grid_nm=WAVELENGTHS_NM.copy(),
        sample_shares=np.ones(len(nodes)),
        references=tuple(range(len(nodes))),
        light_sets=(0,) * len(nodes),
        interpolation=weights,
    )


def _predicted_error(
    plan: PassPlan, weights: FloatArray, lights: FloatArray, transport: FloatArray
) -> tuple[float, float]:
    """Mean and maximum dE2000 of the plan's interpolation `weights` (P, L) over transports (N, L) under the lights."""
    transport = transport / transport.max(1, keepdims=True)
    light = lights[np.arange(len(transport)) % len(lights)]
    nodes = np.searchsorted(plan.grid_nm, plan.wavelengths_nm[:, 0])
    white = spectra_to_xyz(lights[0])
    exact, estimate = (spectra_to_xyz(s * light) for s in (transport, transport[:, nodes] @ weights))
    error = delta_e_2000(exact, np.maximum(estimate, 0.0), white)
    return float(error.mean()), float(error.max())


def save_plan(plan: PassPlan, path: Path) -> None:
    """Write a plan as JSON, whole or not at all."""
    text = json.dumps(
        {
            "format": _FORMAT,
            "kind": plan.kind,
            "wavelengths_nm": plan.wavelengths_nm.tolist(),
            "reconstruction": plan.reconstruction.tolist(),
            "grid_nm": plan.grid_nm.tolist(),
            "sample_shares": plan.sample_shares.tolist(),
            "predicted_de2000": plan.predicted_de2000,
        }
    )
    with written_whole(path) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")


def load_plan(path: Path) -> PassPlan:
    """Read a plan that `save_plan` wrote; numbers come back exactly.

    Raises
    ------
    FileFormatError
        If the file is missing or is no plan.
    """
    wrong = FileFormatError(f"{path} is not a plan of passes. Give the plan.json of a spectral render.")
    try:
        content = json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError:
        raise FileFormatError(f"{path} cannot be read. Give the plan.json of a spectral render.") from None
    except ValueError:
        raise wrong from None
    if not isinstance(content, dict) or content.get("format") != _FORMAT:
        raise wrong
    try:
        predicted = content["predicted_de2000"]
        plan = PassPlan(
            kind=content["kind"],
            wavelengths_nm=np.array(content["wavelengths_nm"], float),
            reconstruction=np.array(content["reconstruction"], float),
            grid_nm=np.array(content["grid_nm"], float),
            sample_shares=np.array(content["sample_shares"], float),
            references=tuple(range(len(content["sample_shares"]))),
            light_sets=(0,) * len(content["sample_shares"]),
            predicted_de2000=None if predicted is None else (float(predicted[0]), float(predicted[1])),
        )
    except (KeyError, TypeError, ValueError, IndexError):
        raise wrong from None
    shapes = (plan.wavelengths_nm.shape, plan.reconstruction.shape, plan.sample_shares.shape)
    passes = len(plan.sample_shares)
    if plan.kind not in ("light-basis", "wavelength") or shapes != (
        (passes, 3),
        (passes, 3, len(plan.grid_nm)),
        (passes,),
    ):
        raise wrong
    return plan
