"""The rim near an outline that somebody is dragging, found in a worker thread while the window goes on."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ..spectral_probe.model import Capture, ViewSettings
from .view_outline import ViewOutline, described, outline_in

if TYPE_CHECKING:
    from ..spectral_probe.model import Outline, Photograph


_SMALL_PX = 8_000_000


@dataclass(frozen=True)
class _Question:
    """A view with the outline asked for; of all its photographs, or of the one shown."""

    view: ViewSettings
    everything: bool = False
    final: bool = False


class RimFollower:
    """Answers with the rim near the outline last asked for: from one photograph at once, from all of them at the end.

    No more than one question waits: whoever drags wants to know of where the outline is now. Touches no Blender data.
    """

    def __init__(
        self, capture: Capture, view: ViewSettings, photo: int, shift_px: tuple[float, float] = (0.0, 0.0)
    ) -> None:
        """Follow in a view; `photo` is shown, and its ball lies `shift_px` from where it is in the first one."""
        self._capture, self._view, self._shift_px = capture, view, shift_px
        self._first = min(photo, len(view.photos) - 1)
        self._read: dict[int, Photograph] = {}  # only the worker touches it
        self._worker = ThreadPoolExecutor(max_workers=1)
        self._running: tuple[_Question, Future[ViewOutline]] | None = None
        self._waiting: _Question | None = None

    def ask(self, outline: tuple[float, ...], *, snap: bool, final: bool = False) -> None:
        """Ask for the rim near an outline in the first photograph's pixels, or with `snap` off for what it says by itself."""
        view = replace(self._view, outline=outline, snap_outline=snap, filter=None)
        self._waiting = _Question(view, everything=final, final=final)

    def answer(self) -> tuple[ViewOutline, bool] | None:
        """The next answer, and whether it is final; None where none is ready. Call it again and again: it starts questions.

        Raises
        ------
        SpectralProbeError
            What the search says is wrong.
        """
        ready = None
        if self._running is not None and self._running[1].done():
            (question, search), self._running = self._running, None
            if not question.final or self._waiting is None:  # else asked anew since
                ready = question, search
            if self._waiting is None and not question.everything and self._small():
                self._waiting = replace(question, everything=True)  # whoever drags has stopped for a while
        if self._running is None and self._waiting is not None:
            question, self._waiting = self._waiting, None
            self._running = question, self._worker.submit(self._search, question)
        return None if ready is None else (ready[1].result(), ready[0].final)

    def close(self) -> None:
        """Drop questions and photographs. A search that runs ends by itself, and its answer is lost."""
        self._waiting = None
        self._worker.shutdown(wait=False, cancel_futures=True)

    def _small(self) -> bool:
        """Whether all photographs are soon read and searched."""
        return sum(one.clipped.size for one in self._read.values()) * len(self._view.photos) < _SMALL_PX

    def _search(self, question: _Question) -> ViewOutline:
        view = question.view
        if question.everything:
            everything = [self._photograph(number) for number in range(len(view.photos))]
            return outline_in(everything, view, self._capture)
        from ..spectral_probe.view import locate_ball

        (x_px, y_px, *size), shift_px = view.outline or (), self._shift_px
        there = replace(view, outline=(x_px + shift_px[0], y_px + shift_px[1], *size))
        photograph = self._photograph(self._first)
        found = locate_ball([photograph], there)
        back = moved(found.outlines[0], (-shift_px[0], -shift_px[1]))
        return described(replace(found, outlines=(back,)), photograph, self._capture)

    def _photograph(self, number: int) -> Photograph:
        if number not in self._read:
            from ..spectral_probe.photo.read import read_photograph

            path = self._view.photos[number]
            self._read[number] = read_photograph(path, half_size=self._capture.camera.half_size)
        return self._read[number]


def moved(outline: Outline, shift_px: tuple[float, float]) -> Outline:
    """An outline elsewhere in its photograph."""
    x_px, y_px = outline.centre_px
    centre = (x_px + shift_px[0], y_px + shift_px[1])
    return replace(outline, centre_px=centre, points_px=outline.points_px + shift_px)
