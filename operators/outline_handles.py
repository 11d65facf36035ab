"""The outline that is edited by hand, its handles, and what dragging one of them does. Plain Python."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

HANDLES = ("CENTRE", "RIGHT", "BOTTOM", "LEFT", "TOP")
"""The centre, and the ends of the semi-axes: the first is that of the radius (RIGHT, LEFT), the second that across it."""

LEAST_RADIUS_PX = 2.0


@dataclass(frozen=True)
class HandOutline:
    """A circle, or with `second_px` above 0 an ellipse, in pixels of a photograph.

    `angle_rad` is the direction of the first semi-axis, from +x towards +y (down).
    """

    x_px: float
    y_px: float
    radius_px: float
    second_px: float = 0.0
    angle_rad: float = 0.0

    @property
    def round(self) -> bool:
        """Whether it is a circle."""
        return self.second_px <= 0.0

    def handle(self, name: str) -> tuple[float, float]:
        """Where a handle lies."""
        if name == "CENTRE":
            return self.x_px, self.y_px
        angle, length = self._arm(name)
        return self.x_px + length * math.cos(angle), self.y_px + length * math.sin(angle)

    def dragged(self, name: str, to_px: tuple[float, float]) -> HandOutline:
        """The outline with a handle somewhere else.

        The centre moves all. An end of a circle's axis sets the radius; that of an ellipse its semi-axis, and the end of the
        first one the angle too.

        Examples
        --------
        >>> HandOutline(100, 100, 50).dragged("RIGHT", (100, 160)).radius_px
        60.0
        >>> HandOutline(100, 100, 50, 40).dragged("BOTTOM", (100, 145)).second_px
        45.0
        """
        if name == "CENTRE":
            return replace(self, x_px=to_px[0], y_px=to_px[1])
        away_x, away_y = to_px[0] - self.x_px, to_px[1] - self.y_px
        length = max(math.hypot(away_x, away_y), LEAST_RADIUS_PX)
        if self.round:
            return replace(self, radius_px=length)
        turn = math.atan2(away_y, away_x) - self._arm(name)[0]
        across = name in {"TOP", "BOTTOM"}
        size = {"second_px": length} if across else {"radius_px": length}
        return replace(self, angle_rad=(self.angle_rad + turn) % (2.0 * math.pi), **size)

    def _arm(self, name: str) -> tuple[float, float]:
        """Direction and length from the centre to a handle on the rim."""
        turn = HANDLES.index(name) - 1
        second = turn % 2 == 1 and not self.round
        angle = turn * math.pi / 2 + (0.0 if self.round else self.angle_rad)
        return angle, self.second_px if second else self.radius_px
