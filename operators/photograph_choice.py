"""Which of the photographs that were given make views of the ball: the others would spoil the light, and are named."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from bpy.app.translations import pgettext_rpt as rpt_

from .photograph_views import named

if TYPE_CHECKING:  # heavy: imported where it is used
    from ..spectral_probe.photo.grouping import ViewGroup

type Moment = tuple[str, float | None, object]


def of_the_ball(groups: Sequence[ViewGroup]) -> tuple[list[ViewGroup], list[str]]:
    """The groups that become views, and a sentence for each kind of those that do not.

    Left out are a single photograph among brackets, such as a background without the ball; of the same photographs at two
    sizes the smaller ones, whose lens is unknown where they were cut; and brackets that say no exposure beside such that do.
    """
    kept, told = list(groups), []
    for wanted, sentence in (
        (
            _bracketed,
            rpt_(
                "{files} left out: single among brackets, such as a background. To add one, import it alone"
            ),
        ),
        (
            _largest,
            rpt_("{files} left out: the same photographs, smaller or cut. Import them alone to use them"),
        ),
        (
            _exposed,
            rpt_("{files} left out: no exposure times, which the others have. Import them alone to add them"),
        ),
    ):
        remaining = wanted(kept)
        left_out = [photo.name for group in kept if group not in remaining for photo in group.photos]
        kept = remaining
        if left_out:
            told.append(sentence.format(files=named(left_out)))
    return kept, told


def _bracketed(groups: Sequence[ViewGroup]) -> list[ViewGroup]:
    return [group for group in groups if "one photograph" not in group.hints]


def _exposed(groups: Sequence[ViewGroup]) -> list[ViewGroup]:
    """All of them where none says its exposures."""
    exposed = [
        group
        for group in groups
        if any(photo.exposure is not None or photo.encoding == "radiance" for photo in group.photos)
    ]
    return exposed or list(groups)


def _largest(groups: Sequence[ViewGroup]) -> list[ViewGroup]:
    """Of groups that share a moment the largest pictures; of equally large ones the longest bracket."""
    by_size = sorted(groups, key=lambda group: (_area_px(group), len(group.photos)), reverse=True)
    kept: list[ViewGroup] = []
    taken: set[Moment] = set()
    for group in by_size:
        moments = {
            (photo.camera, photo.taken_s, photo.exposure)
            for photo in group.photos
            if photo.taken_s is not None
        }
        if not moments & taken:
            kept.append(group)
            taken |= moments
    return [group for group in groups if group in kept]


def _area_px(group: ViewGroup) -> int:
    return max(
        ((photo.size_px or (0, 0))[0] * (photo.size_px or (0, 0))[1] for photo in group.photos), default=0
    )
