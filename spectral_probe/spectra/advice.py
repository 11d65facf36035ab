"""What a user should know of the recovery chosen, in one sentence each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from .library import check_families
from .prior import OTHER

_SMOOTH = frozenset({"incandescent", "daylight"})

_MUCH = 0.05
"""Share of the light that must be unlike the lamps expected to be worth a word."""


def recovery_advice(method: str, families: Sequence[str], channels: int) -> list[str]:
    """Warnings about a choice of method and lamp families.

    Parameters
    ----------
    method, families
        As given to `recovery.spectral_recovery`.
    channels
        C, three for each photo set.

    Examples
    --------
    >>> recovery_advice("family", ["incandescent", "daylight"], 3)
    []
    >>> len(recovery_advice("paper", ["automatic"], 3)), len(recovery_advice("automatic", ["daylight"], 3))
    (1, 1)
    """
    allowed = check_families(["automatic"] if method == "automatic" else families)
    if method == "paper":
        if set(allowed) <= _SMOOTH:
            return []
        return [
            (
                f"The basis of {channels} principal components spans {len(allowed)} lamp families, and serves none of them well: "
                "expect wrong and negative spectra. Name only the families that are present, or use the method family."
            )
        ]
    if len(allowed) < 4 or channels > 3:
        return []
    return [
        (
            f"{len(allowed)} lamp families are allowed, and three channels cannot tell them apart: lines and bands are "
            "guesses. Name the families that are present, or photograph again through a colour filter."
        )
    ]


def light_advice(kinds: Mapping[str, float]) -> list[str]:
    """Warnings about the light found: `kinds` are the shares of the kinds of light in it.

    Examples
    --------
    >>> light_advice({"daylight": 0.9, "unexpected": 0.1})[0][:45]
    '10 % of the light is unlike the lamp families'
    """
    share = kinds.get(OTHER, 0.0)
    if share < _MUCH:
        return []
    return [
        f"{share:.0%} of the light is unlike the lamp families said to be present".replace("%", " %")
        + ". Name more families, and check the camera."
    ]
