"""Ellipses in an image: what a ball's outline is."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..model import FloatArray, Outline


def full_turn(count: int) -> FloatArray:
    """`count` angles spread evenly over a turn, in radians."""
    return (np.arange(count) + 0.5) * (2.0 * np.pi / count)


@dataclass(frozen=True)
class Ellipse:
    """An ellipse in pixels; `angle_rad` of the major axis from +x towards +y."""

    x: float
    y: float
    major: float
    minor: float
    angle_rad: float = 0.0

    @property
    def radius(self) -> float:
        """Mean of the semi-axes."""
        return 0.5 * (self.major + self.minor)

    def radius_at(self, angles_rad: FloatArray) -> FloatArray:
        """Distance of the ellipse from its centre in directions given in the image.

        Examples
        --------
        >>> Ellipse(0, 0, 4, 3).radius_at(np.array([0.0, np.pi / 2])).tolist()
        [4.0, 3.0]
        """
        across = self.minor * np.cos(angles_rad - self.angle_rad)
        along = self.major * np.sin(angles_rad - self.angle_rad)
        return np.asarray(self.major * self.minor / np.hypot(across, along))

    def moved(self, shift_px: FloatArray) -> Ellipse:
        """The ellipse elsewhere: `shift_px` (x, y) is added to its centre."""
        return replace(self, x=self.x + float(shift_px[0]), y=self.y + float(shift_px[1]))

    def changed(self, change: FloatArray) -> Ellipse:
        """The ellipse after small changes of x, y, radius and, where given, ellipticity (`harmonics`)."""
        x, y, radius = (float(value) for value in change[:3])
        second = 0.5 * (self.major - self.minor) * np.exp(2j * self.angle_rad)
        if len(change) > 3:
            second += complex(change[3], change[4])
        bulge = abs(second)
        mean = self.radius + radius
        return Ellipse(self.x + x, self.y + y, mean + bulge, mean - bulge, float(np.angle(second)) / 2.0)

    def points(self, angles_rad: FloatArray) -> FloatArray:
        """Points (N, 2) of the ellipse in directions given in the image."""
        direction = np.stack([np.cos(angles_rad), np.sin(angles_rad)], axis=-1)
        return np.asarray([self.x, self.y] + self.radius_at(angles_rad)[:, None] * direction)

    @staticmethod
    def of(outline: Outline) -> Ellipse:
        """The ellipse of an outline."""
        return Ellipse(*outline.centre_px, *outline.semi_axes_px, outline.angle_rad)
