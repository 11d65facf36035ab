"""Which light group each lamp and emitting object shines in, and which of its three channels holds which spectrum.

A Cycles light group has three channels, and an object is in one group. Light of varying colour needs all three, as weights of the
three RGB illuminants; a measured lamp, or light of one constant colour, needs one channel. A spectrum keeps its channel number in
all groups, since one material may light several objects.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

RGB_GROUP = "emission"
"""The light group of emission that is known by its colour."""

LAMP_GROUP = "lamps {number}"
"""Names of the groups of lamps of one spectrum each channel, from 1."""


@dataclass(frozen=True)
class Emitter:
    """A lamp, or one emitting shader of a material.

    Parameters
    ----------
    lamp
        Name of its spectrum, "" where only its colour is known.
    constant
        Name of the spectrum of its colour where that is the same everywhere, so that one channel can hold it; "" otherwise.
    """

    lamp: str = ""
    constant: str = ""


@dataclass(frozen=True)
class Assignment:
    """Who shines where.

    Parameters
    ----------
    spectra
        For each emitter the name of the one spectrum it has, "" where it shines as RGB.
    channels
        Channel 0..2 of each spectrum.
    groups
        Light group of each object.
    members
        By name of a lamp group, the spectra in its three channels; "" for an empty one.
    """

    spectra: tuple[str, ...]
    channels: Mapping[str, int]
    groups: tuple[str, ...]
    members: Mapping[str, tuple[str, str, str]]


def assign(emitters: Sequence[Emitter], objects: Sequence[frozenset[int]]) -> Assignment:
    """Give every emitting object a light group and every spectrum a channel.

    Parameters
    ----------
    emitters
        All emitters of the scene.
    objects
        For each emitting object the numbers of the emitters that shine from it.

    Returns
    -------
    Assignment
        Where an object cannot be served (it has a texture's light and a measured lamp's, or more than three spectra), its
        lamps shine as RGB.

    Examples
    --------
    >>> lamps = [Emitter("FL11"), Emitter("HP1"), Emitter(constant="red")]
    >>> alone = assign(lamps, [frozenset({0}), frozenset({1}), frozenset({2})])
    >>> alone.groups, alone.members
    (('lamps 1', 'lamps 1', 'emission'), {'lamps 1': ('FL11', 'HP1', '')})
    >>> together = assign(lamps, [frozenset({0, 2}), frozenset({1})])
    >>> together.groups, together.spectra
    (('lamps 1', 'lamps 1'), ('FL11', 'HP1', 'red'))
    """
    spectra = [emitter.lamp for emitter in emitters]
    forced = [False] * len(emitters)  # to RGB, for good
    while True:
        _agree(emitters, objects, spectra, forced)
        wanted = [frozenset(spectra[e] for e in members) - {""} for members in objects]
        channels, unserved = _coloured(wanted)
        if unserved is None:
            break
        for emitter in objects[unserved]:
            spectra[emitter], forced[emitter] = "", True
    maps: list[dict[int, str]] = []
    groups = []
    for names in wanted:
        if not names:
            groups.append(RGB_GROUP)
            continue
        needed = {channels[name]: name for name in names}
        number = next((n for n, held in enumerate(maps) if _compatible(held, needed)), len(maps))
        if number == len(maps):
            maps.append({})
        maps[number].update(needed)
        groups.append(LAMP_GROUP.format(number=number + 1))
    members = {
        LAMP_GROUP.format(number=number + 1): (held.get(0, ""), held.get(1, ""), held.get(2, ""))
        for number, held in enumerate(maps)
    }
    return Assignment(tuple(spectra), channels, tuple(groups), members)


def _agree(
    emitters: Sequence[Emitter], objects: Sequence[frozenset[int]], spectra: list[str], forced: list[bool]
) -> None:
    """Where an object has light of one spectrum and of a colour, make both the one or the other.

    Every step takes an emitter from its colour to its constant spectrum, or for good to its colour: it ends.
    """
    changed = True
    while changed:
        changed = False
        for members in objects:
            coloured = [e for e in members if not spectra[e]]
            single = [e for e in members if spectra[e]]
            if not coloured or not single:
                continue
            changed = True
            if all(emitters[e].constant and not forced[e] for e in coloured):
                for e in coloured:
                    spectra[e] = emitters[e].constant
            else:
                for e in single:
                    spectra[e], forced[e] = "", True


def _coloured(wanted: Sequence[frozenset[str]]) -> tuple[dict[str, int], int | None]:
    """A channel for each spectrum, others on the same object having others; or the object that cannot be served."""
    crowded = next((n for n, names in enumerate(wanted) if len(names) > 3), None)
    if crowded is not None:
        return {}, crowded
    beside: dict[str, set[str]] = {}
    for names in wanted:
        for name in sorted(names):
            beside.setdefault(name, set()).update(names - {name})
    channels: dict[str, int] = {}
    held = [0, 0, 0]  # spectra in each channel: fill them evenly, so that few groups hold them
    while len(channels) < len(beside):
        # The most constrained first (Brelaz 1979, doi:10.1145/359094.359101)
        name = max(
            (n for n in beside if n not in channels),
            key=lambda n: (len({channels[m] for m in beside[n] if m in channels}), len(beside[n])),
        )
        free = sorted(
            {0, 1, 2} - {channels[m] for m in beside[name] if m in channels}, key=lambda c: (held[c], c)
        )
        if not free:
            return {}, next(n for n, names in enumerate(wanted) if name in names and len(names) > 1)
        channels[name] = free[0]
        held[free[0]] += 1
    return channels, None


def _compatible(held: Mapping[int, str], needed: Mapping[int, str]) -> bool:
    return all(held.get(channel, name) == name for channel, name in needed.items())
