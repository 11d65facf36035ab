"""The picture that an alignment is judged by: the ball's photograph and the plate, the ball and the ground drawn into both."""

from __future__ import annotations

import cv2
import numpy as np

from ..composite.matching import PlateMatch
from ..composite.plate_geometry import at_size, world_to_plate
from ..composite_model import Backplate
from ..geometry.camera import pixel_rays, project
from ..model import FloatArray, Photograph
from ..photo.samples import linear_to_srgb
from .display import Picture

_WIDTH_PX = 1000
_BALL, _GROUND, _FOOT = (0, 230, 255), (255, 190, 40), (255, 60, 60)  # R, G, B
_SUBPIXEL = 4
"""Bits of a pixel's fraction in OpenCV's drawing."""


def alignment_picture(match: PlateMatch, ground_radius_m: float) -> Picture:
    """The photograph of the ball, turned as the plate's camera stood, and the plate, side by side.

    The ball's outline (cyan) must lie on the photographed ball, the rings (amber) flat on the ground round its foot (red).

    Returns
    -------
    ndarray
        (h, w, 3) uint8; only the plate where the photograph of the ball is gone.
    """
    backplate = match.backplate
    width, height = backplate.camera.size_px
    size = (min(width, _WIDTH_PX), max(1, round(height * min(width, _WIDTH_PX) / width)))
    pictures = [_display(match.photograph, size)]
    if match.beside is not None:
        turn = np.eye(3) if match.alignment is None else match.alignment.turn
        pictures.insert(0, _turned(_display(match.beside, size), backplate, size, turn))
    for picture in pictures:
        _draw(picture, backplate, size, ground_radius_m)
    return np.ascontiguousarray(np.hstack(pictures))


def _display(photograph: Photograph, size: tuple[int, int]) -> Picture:
    small = np.asarray(cv2.resize(photograph.pixels, size, interpolation=cv2.INTER_AREA))
    if not photograph.display_referred:
        small = small / max(float(np.quantile(small, 0.98)), 1e-9)
    return np.asarray(np.rint(255.0 * np.clip(linear_to_srgb(small), 0.0, 1.0)), np.uint8)


def _turned(picture: Picture, backplate: Backplate, size: tuple[int, int], turn: FloatArray) -> Picture:
    """The picture as a camera sees it that turned by a rotation (3, 3)."""
    camera = at_size(backplate.camera, size)
    points = np.stack(np.meshgrid(np.arange(size[0]) + 0.5, np.arange(size[1]) + 0.5), axis=-1)
    places = (project(camera, pixel_rays(camera, points) @ turn) - 0.5).astype(np.float32)
    return np.asarray(cv2.remap(picture, places, None, cv2.INTER_LINEAR), np.uint8)


def _draw(picture: Picture, backplate: Backplate, size: tuple[int, int], ground_radius_m: float) -> None:
    scale = size[0] / backplate.camera.size_px[0]
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    circle = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=-1)
    for share in (0.125, 0.25, 0.5, 1.0):
        _line(picture, world_to_plate(backplate, share * ground_radius_m * circle) * scale, _GROUND)
    if backplate.ball_centre_m is None:
        return
    foot = (
        0.2 * backplate.ball_radius_m * np.array([[-1.0, 0, 0], [1, 0, 0], [0, 0, 0], [0, 1, 0], [0, -1, 0]])
    )
    _line(picture, world_to_plate(backplate, foot) * scale, _FOOT)
    _line(picture, ball_outline(backplate) * scale, _BALL)


def ball_outline(backplate: Backplate) -> FloatArray:
    """Points (N, 2) of the ball's outline in the plate, in pixels; closed.

    Examples
    --------
    >>> from pathlib import Path
    >>> from ..model import Camera
    >>> level = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # looks along +Y, z up
    >>> plate = Backplate(
    ...     Camera((100.0, 100.0), (50.0, 40.0), (100, 80)), level, np.array([0.0, -2.0, 0.0]), Path(), (100, 80),
    ...     (0.0, 0.0, 100, 80), np.zeros(3), 1.0,
    ... )
    >>> (ball_outline(plate).max(0) - [50, 40]).round(2).tolist()  # tan(30 degrees)
    [57.74, 57.74]
    """
    to_centre = np.asarray(backplate.ball_centre_m, float) - backplate.position_m
    distance = float(np.linalg.norm(to_centre))
    axis, sine = to_centre / distance, backplate.ball_radius_m / distance
    right = np.cross(axis, backplate.rotation[:, 1])
    right /= np.linalg.norm(right)
    angle = np.linspace(0.0, 2.0 * np.pi, 361)[:, None]
    rim = np.sqrt(1.0 - sine**2) * axis + sine * (
        np.cos(angle) * right + np.sin(angle) * np.cross(axis, right)
    )
    return world_to_plate(backplate, backplate.position_m + rim)


def _line(picture: Picture, points: FloatArray, colour: tuple[int, int, int]) -> None:
    """A line through points (N, 2) in pixels, interrupted where one is behind the camera or far off."""
    near = np.isfinite(points).all(-1) & (np.abs(np.nan_to_num(points)).max(-1) < 30_000)
    places = np.rint((np.nan_to_num(points) - 0.5) * 2**_SUBPIXEL).astype(np.int32)
    for first, second, shown in zip(places[:-1], places[1:], near[:-1] & near[1:], strict=True):
        if shown:
            cv2.line(
                picture, tuple(first.tolist()), tuple(second.tolist()), colour, 1, cv2.LINE_AA, _SUBPIXEL
            )
