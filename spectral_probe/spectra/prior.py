"""What light may be there: the classes of spectra that an estimate chooses between.

A class is described by the second moment of its spectra, scaled to unit norm: a Gaussian of unknown level and zero mean. Seen
through a camera it is an angular central Gaussian, whose tails are heavy: a light unlike those of the library is not ruled out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from .library import FAMILIES, check_families, surface_reflectances, training_lights

OWN = "own"
"""Name of the class of the user's own measured lights."""

MIXED = "mixed"
"""Name of the class of light from lamps of several families at once, or from lamps of no family in particular."""

REFLECTED = "reflected"
"""Name of the class of lamp light that a surface has reflected."""

OTHER = "unexpected"
"""Name of the class of light from lamps of families that were not said to be present."""

ALIKE = 0.995
"""Goodness of fit beyond which two lights are taken for one when an estimate is tried on lights it has not seen."""

_SHRINKAGE = 0.15
"""Share of all lights in the moment of each family: ten lamps do not show all that a family can be."""

_OTHER_SHARE = 0.002
"""A-priori probability of light from a lamp family that was not said to be present."""

_NEUTRAL = 0.5
"""Share of grey and white surfaces (walls, ceilings, concrete, paper) in what reflects light; the others are a ColorChecker's."""


@dataclass(frozen=True)
class LightClass:
    """One kind of light that may be there.

    Parameters
    ----------
    name
        A lamp family, or `OWN`, `MIXED`, `REFLECTED` or `OTHER`.
    spectra
        (N, L) spectra of unit norm.
    shares
        (N,) how much each counts in the class's second moment; they sum to one.
    members
        (N,) bool, spectra that are themselves of the class; others only broaden it.
    kin
        (N,) numbers: to try an estimate on a member, everything that has its number is left out, if `kin` is given for the
        class, else what is alike (`ALIKE`).
    share
        A-priori probability among the classes that are seen directly, or among those that are reflected.
    direct
        Whether the light is seen directly, or from a surface that reflects it; None if it may be either.
    """

    name: str
    spectra: FloatArray
    shares: FloatArray
    members: BoolArray
    share: float
    direct: bool | None
    kin: IntArray | None = None

    @property
    def moment(self) -> FloatArray:
        """Second moment of the class, (L, L), of trace one."""
        return np.asarray((self.spectra * self.shares[:, None]).T @ self.spectra)

    def folds(self) -> list[tuple[IntArray, BoolArray]]:
        """Members to try an estimate on, and what it may be made from: at least three spectra.

        The user's own lights are known, so nothing is left out for them.
        """
        members = np.flatnonzero(self.members)
        if self.name == OWN:
            return [(members, np.ones(len(self.spectra), bool))]
        kin = self.kin
        if kin is not None:
            return [(members[kin[members] == k], kin != k) for k in range(int(kin.max()) + 1)]
        folds = []
        for index in members:
            others = np.asarray(self.spectra @ self.spectra[index] <= ALIKE)
            if np.count_nonzero(others & self.members) < 3:
                others = np.arange(len(self.spectra)) != index
            folds.append((np.array([index]), others))
        return folds


def light_classes(families: Sequence[str], own: FloatArray | None = None) -> tuple[LightClass, ...]:
    """The classes of light of lamp families: each family seen directly, their mixtures, and their light reflected by surfaces.

    Parameters
    ----------
    families
        Lamp families, or "automatic" for all.
    own
        (N, L) measured lights of the user's, which form a family of their own.

    Returns
    -------
    tuple
        One class for each family, `MIXED` where there are several families, `REFLECTED`, and `OTHER` unless all are named.

    Raises
    ------
    SpectralDataError
        If a family is unknown.

    Examples
    --------
    >>> [light_class.name for light_class in light_classes(["incandescent", "daylight"])]
    ['incandescent', 'daylight', 'mixed', 'reflected', 'unexpected']
    """
    named = {family: training_lights([family]) for family in check_families(families)}
    if own is not None and len(own):
        named[OWN] = np.asarray(own, float)
    others = {family: training_lights([family]) for family in FAMILIES}
    return classes_of(
        *({name: unit_norm(lights) for name, lights in known.items()} for known in (named, others))
    )


def classes_of(
    lights: Mapping[str, FloatArray], all_lights: Mapping[str, FloatArray] | None = None
) -> tuple[LightClass, ...]:
    """The classes of families given by their lights of unit norm, (N, L) each; `all_lights` are those of `OTHER`."""
    spectra = np.concatenate(list(lights.values()))
    family = np.repeat(np.arange(len(lights)), [len(own) for own in lights.values()])
    every = 1.0 / (len(lights) * np.bincount(family)[family])  # families count alike
    several = len(lights) > 1
    classes = [
        LightClass(
            name,
            spectra,
            _SHRINKAGE * every + (1 - _SHRINKAGE) * (family == number) / np.count_nonzero(family == number),
            family == number,
            0.5 / len(lights) if several else 1.0,
            direct=True,
        )
        for number, name in enumerate(lights)
    ]
    if several:
        classes.append(LightClass(MIXED, spectra, every, np.ones(len(spectra), bool), 0.5, direct=True))
    classes.append(_reflected(spectra, every))
    if all_lights is not None and set(all_lights) - set(lights):
        classes.append(_other(all_lights))
    return tuple(classes)


def _other(lights: Mapping[str, FloatArray]) -> LightClass:
    """Light of any family, from any surface; tried with the whole family left out that it comes from."""
    spectra = np.concatenate(list(lights.values()))
    family = np.repeat(np.arange(len(lights)), [len(own) for own in lights.values()])
    anything = _reflected(spectra, 1.0 / (len(lights) * np.bincount(family)[family]))
    surfaces = len(anything.spectra) // len(spectra)
    return replace(anything, name=OTHER, share=_OTHER_SHARE, direct=None, kin=np.repeat(family, surfaces))


def _reflected(spectra: FloatArray, shares: FloatArray) -> LightClass:
    """Every light reflected by every surface: half of what is seen is grey and white, the rest a ColorChecker's colours."""
    surfaces = np.concatenate([np.ones((1, spectra.shape[1])), surface_reflectances()])
    of_surface = np.r_[_NEUTRAL, np.full(len(surfaces) - 1, (1 - _NEUTRAL) / (len(surfaces) - 1))]
    products = unit_norm((spectra[:, None] * surfaces).reshape(-1, spectra.shape[1]))
    return LightClass(
        REFLECTED,
        products,
        (shares[:, None] * of_surface).reshape(-1),
        np.ones(len(products), bool),
        1.0,
        direct=False,
        kin=np.tile(np.arange(len(surfaces)), len(spectra)),
    )


def unit_norm(spectra: FloatArray) -> FloatArray:
    """Spectra (..., L) scaled to unit Euclidean norm."""
    return np.asarray(spectra / np.linalg.norm(spectra, axis=-1, keepdims=True))
