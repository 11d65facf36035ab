"""What a ball's outline may look like: a circle or an ellipse, or, where the camera is known, the picture of a cone.

Rays through the outline of a sphere make a circular cone (fig. 4): its axis and its half angle are all there is to
find, three numbers, whatever the lens does to their picture. So with a known camera half a rim tells the whole.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..model import BoolArray, Camera, FloatArray
from .ball import cone_of_rays, cone_rays
from .camera import pixel_rays, project
from .ellipse import Ellipse, fitted_ellipse, full_turn, harmonics

POINTS = 180
ROUNDS, OUTLIER = 15, 3.0


@dataclass(frozen=True)
class RimShape:
    """The family of outlines that are looked for.

    With a `camera` they are pictures of cones; without one, ellipses that change in their first `terms` harmonics: 3 keep
    the ellipticity they have, 5 leave it free. Changes are in pixels: about that of the centre's x, y and of the radius.
    """

    camera: Camera | None = None
    terms: int = 3

    def nearest(self, ellipse: Ellipse) -> Ellipse:
        """The outline of this family that is nearest to an ellipse."""
        if self.camera is None:
            return ellipse
        axis, angle = cone_of_rays(pixel_rays(self.camera, ellipse.points(full_turn(POINTS))))
        return _picture_of_cone(self.camera, axis, angle, ellipse)

    def basis(self, ellipse: Ellipse, angles_rad: FloatArray) -> FloatArray:
        """How far (A, n) the outline moves outwards at each angle for a unit of each change."""
        if self.camera is None:
            return harmonics(angles_rad, self.terms)
        step = 1e-3 * ellipse.radius
        columns = []
        for index in range(3):
            change = np.zeros(3)
            change[index] = step
            moved = self.changed(ellipse, change)
            _, offset = ellipse.offsets(moved.points(angles_rad + 0.0))
            columns.append(offset / step)
        return np.stack(columns, axis=-1)

    def changed(self, ellipse: Ellipse, change: FloatArray) -> Ellipse:
        """The outline after changes (n,)."""
        if self.camera is None:
            return ellipse.changed(change)
        axis, angle = cone_of_rays(pixel_rays(self.camera, ellipse.points(full_turn(POINTS))))
        # A move by a pixel at the outline's own middle, and a radius larger by a pixel of the mean radius there.
        centre = project(self.camera, axis)
        moved = pixel_rays(self.camera, centre + change[:2])
        return _picture_of_cone(self.camera, moved, angle * (1.0 + change[2] / ellipse.radius), ellipse)

    def fitted(self, ellipse: Ellipse, points_px: FloatArray) -> tuple[Ellipse, BoolArray]:
        """The outline that fits points (N, 2) best by least squares, and which (N,) were not too far off to count."""
        used = np.ones(len(points_px), bool)
        for _ in range(ROUNDS):
            angle, offset = ellipse.offsets(points_px)
            basis = self.basis(ellipse, angle)
            change = np.linalg.lstsq(basis[used], offset[used], rcond=None)[0]
            residual = offset - basis @ change
            scale = 1.4826 * float(np.median(np.abs(residual)))
            now = np.abs(residual) <= OUTLIER * scale + 1e-9
            ellipse = self.changed(ellipse, change)
            settled = np.abs(change).max() < 1e-4 and (now == used).all()
            used = now if now.sum() > len(change) + 3 else used
            if settled:
                break
        return ellipse, used


def _picture_of_cone(camera: Camera, axis: FloatArray, angle_rad: float, start: Ellipse) -> Ellipse:
    """The ellipse that a cone's picture is; what a lens' distortion leaves over is far below a tenth of a pixel."""
    return fitted_ellipse(project(camera, cone_rays(axis, angle_rad, full_turn(POINTS))), start)
