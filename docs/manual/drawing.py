"""Draws pictures/photographing.svg: where the camera stands round the ball, and what a photograph must show.

.venv/bin/python docs/manual/drawing.py
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np

mpl.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.patches import Circle, Polygon, Rectangle, Wedge

PAGE = Path(__file__).resolve().parent / "pictures" / "photographing.svg"
DISTANCE = 6.0
"""Of the cameras in the drawing, in radii of the ball: nearer than in life, or nothing could be seen of it."""

_INK, _GREY, _LIGHT, _CONE = "#333333", "#888888", "#dddddd", "#e8a33d"


def main() -> None:
    """Draw both halves and write the file."""
    mpl.rcParams.update(
        {"svg.fonttype": "none", "svg.hashsalt": "manual", "font.family": "sans-serif", "font.size": 11}
    )
    figure, (above, frames) = plt.subplots(
        1, 2, figsize=(11, 5.2), gridspec_kw={"width_ratios": (1.15, 1)}, facecolor="white"
    )
    _from_above(above)
    _frames(frames)
    for axes in (above, frames):
        axes.set_aspect("equal")
        axes.axis("off")
    figure.tight_layout()
    figure.savefig(PAGE, metadata={"Date": None})


def _from_above(axes: Any) -> None:
    """Three views from above, with the cone that the first does not see."""
    half_deg = np.degrees(np.arcsin(1 / DISTANCE))
    axes.add_patch(Wedge((0, 0), 8.2, 90 - half_deg, 90 + half_deg, color=_CONE, alpha=0.35, lw=0))
    axes.text(
        0,
        8.6,
        "not seen by view 1: a cone\nbehind the ball, r / d wide to each side",
        ha="center",
        va="bottom",
    )
    for number, azimuth_deg in enumerate((0, 120, 240), 1):
        looking = np.radians(90 - azimuth_deg)
        place = -DISTANCE * np.array([np.cos(looking), np.sin(looking)])
        axes.plot(*zip(place, (0, 0), strict=True), color=_GREY, lw=1, ls=(0, (5, 4)))
        _camera(axes, place, looking)
        label = place * (1.32 if number == 1 else 1.45)
        axes.text(*label, f"view {number}\nbearing {azimuth_deg}°", ha="center", va="center")
    axes.add_patch(Circle((0, 0), 1, facecolor=_LIGHT, edgecolor=_INK, lw=1.5))
    axes.annotate("", (-0.45, 0), (-0.45, -DISTANCE), arrowprops={"arrowstyle": "<->", "color": _INK})
    axes.text(-0.7, -DISTANCE / 2, "distance d:\n10 to 40 radii", ha="right", va="center")
    axes.annotate("", (6.5, -3.0), (6.5, -6.0), arrowprops={"arrowstyle": "->", "color": _INK})
    axes.text(6.5, -2.7, "+Y, bearing 0", ha="center", va="bottom")
    axes.set_xlim(-9.5, 9.5)
    axes.set_ylim(-9, 11)
    axes.set_title("From above", fontsize=12)


def _camera(axes: Any, place: Any, looking: float) -> None:
    ahead = np.array([np.cos(looking), np.sin(looking)])
    aside = np.array([-ahead[1], ahead[0]])
    body = [
        place - aside * 0.6,
        place + aside * 0.6,
        place + aside * 0.6 - ahead,
        place - aside * 0.6 - ahead,
    ]
    lens = [
        place - aside * 0.3,
        place + aside * 0.3,
        place + aside * 0.3 + ahead * 0.5,
        place - aside * 0.3 + ahead * 0.5,
    ]
    for corners in (body, lens):
        axes.add_patch(Polygon(corners, closed=True, color=_INK))


def _frames(axes: Any) -> None:
    """A good photograph and three bad ones."""
    cases = (
        ("good: whole, sharp, large", (0.0, 0.0), 1.0, "#3a8f3a"),
        ("bad: the rim is cut", (1.4, 0.0), 1.0, "#b33a3a"),
        ("bad: too small", (0.0, 0.0), 0.22, "#b33a3a"),
        ("bad: a stand hides the rim", (0.0, 0.0), 1.0, "#b33a3a"),
    )
    for index, (text, centre, radius, colour) in enumerate(cases):
        left, bottom = 4.6 * (index % 2), -4.2 * (index // 2)
        frame = Rectangle((left, bottom), 4, 2.7, facecolor="#f7f7f7", edgecolor=_INK, lw=1.2)
        axes.add_patch(frame)
        ball = Circle(
            (left + 2 + centre[0], bottom + 1.35 + centre[1]),
            radius * 1.2,
            facecolor=_LIGHT,
            edgecolor=_INK,
            lw=1.5,
        )
        axes.add_patch(ball)
        ball.set_clip_path(frame)
        if "stand" in text:
            axes.add_patch(Rectangle((left + 1.2, bottom), 1.6, 0.75, color=_GREY))
        axes.text(left + 2, bottom - 0.25, text, ha="center", va="top", color=colour)
    axes.set_xlim(-0.3, 8.9)
    axes.set_ylim(-5.2, 3.2)
    axes.set_title("In the frame", fontsize=12)


if __name__ == "__main__":
    main()
