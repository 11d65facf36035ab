"""Closed curves round a ball: ellipses, and the harmonics in which small changes of an outline are counted."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..model import FloatArray


def full_turn(count: int) -> FloatArray:
    """`count` angles spread evenly over a turn, in radians."""
    return (np.arange(count) + 0.5) * (2.0 * np.pi / count)


def harmonics(angles_rad: FloatArray, count: int) -> FloatArray:
    """The first `count` of cos, sin, 1, cos 2a, sin 2a (A, count): changes of x, y, radius and ellipticity."""
    turns = [np.cos(angles_rad), np.sin(angles_rad), np.ones_like(angles_rad)]
    turns += [np.cos(2.0 * angles_rad), np.sin(2.0 * angles_rad)]
    return np.stack(turns[:count], axis=-1)


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

    def points(self, angles_rad: FloatArray) -> FloatArray:
        """The ellipse's points (A, 2) in directions given in the image."""
        radius = self.radius_at(angles_rad)
        return np.stack([self.x + radius * np.cos(angles_rad), self.y + radius * np.sin(angles_rad)], axis=-1)

    def offsets(self, points_px: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Direction (N,) of points (N, 2) from the centre, and their distance from the ellipse, positive outside.

        Examples
        --------
        >>> angle, offset = Ellipse(1, 0, 4, 3).offsets(np.array([[6.0, 0.0]]))
        >>> float(angle[0]), float(offset[0])
        (0.0, 1.0)
        """
        x, y = points_px[:, 0] - self.x, points_px[:, 1] - self.y
        angle = np.arctan2(y, x)
        return angle, np.hypot(x, y) - self.radius_at(angle)

    def moved(self, shift_px: FloatArray) -> Ellipse:
        """The ellipse elsewhere: `shift_px` (x, y) is added to its centre."""
        return replace(self, x=self.x + float(shift_px[0]), y=self.y + float(shift_px[1]))

    def changed(self, change: FloatArray) -> Ellipse:
        """The ellipse after small changes of x, y, radius and, where given, ellipticity (`harmonics`)."""
        x, y, radius = (float(value) for value in change[:3])
        second = self.ellipticity
        if len(change) > 3:
            second += complex(change[3], change[4])
        bulge = abs(second)
        mean = self.radius + radius
        return Ellipse(self.x + x, self.y + y, mean + bulge, mean - bulge, float(np.angle(second)) / 2.0)

    @property
    def ellipticity(self) -> complex:
        """Half the axes' difference, turned by twice the major axis' angle: amplitudes of cos 2a and sin 2a."""
        return complex(0.5 * (self.major - self.minor) * np.exp(2j * self.angle_rad))


def fitted_ellipse(points_px: FloatArray, start: Ellipse) -> Ellipse:
    """The ellipse nearest to points (N, 2) spread round `start`, by least squares of radial distances.

    Examples
    --------
    >>> true = Ellipse(5, 6, 40, 37, 0.3)
    >>> found = fitted_ellipse(true.points(full_turn(90)), Ellipse(4, 6, 38, 38))
    >>> round(found.x, 6), round(found.major, 6), round(found.angle_rad, 6)
    (5.0, 40.0, 0.3)
    """
    ellipse = start
    for _ in range(8):
        angle, offset = ellipse.offsets(points_px)
        change = np.linalg.lstsq(harmonics(angle, 5), offset, rcond=None)[0]
        ellipse = ellipse.changed(change)
        if np.abs(change).max() < 1e-9 * ellipse.radius:
            break
    return ellipse
