"""Plain solids as Blender objects. Lengths in metres, z up."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import bpy
import numpy as np

type Point = Sequence[float]


def mesh(name: str, points: Any, faces: Any, material: Any, *, smooth: bool = False) -> Any:
    """An object of points (N, 3) and faces (lists of indices), in the scene."""
    data = bpy.data.meshes.new(name)
    data.from_pydata(
        [tuple(map(float, point)) for point in points], [], [tuple(map(int, face)) for face in faces]
    )
    if smooth:
        data.shade_smooth()
    data.materials.append(material)
    made = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(made)
    return made


def box(name: str, centre: Point, size: Point, material: Any, turn_deg: float = 0.0) -> Any:
    """A cuboid, turned about the vertical."""
    corners = (
        np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * np.asarray(size) / 2.0
    )
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    made = mesh(name, corners, faces, material)
    made.location = tuple(centre)
    made.rotation_euler = (0.0, 0.0, np.radians(turn_deg))
    return made


def rectangle(name: str, centre: Point, across: Point, up: Point, material: Any) -> Any:
    """A rectangle whose half sides are the vectors `across` and `up`; it faces across x up."""
    c, a, b = (np.asarray(v, float) for v in (centre, across, up))
    return mesh(name, [c - a - b, c + a - b, c + a + b, c - a + b], [(0, 1, 2, 3)], material)


def ring(
    name: str,
    centre: Point,
    radii: tuple[float, float],
    material: Any,
    arc_deg: tuple[float, float] = (0, 360),
) -> Any:
    """A flat ring, or part of it, facing up; the inner radius may be 0."""
    steps = 96
    angles = np.radians(np.linspace(*arc_deg, steps + 1))
    unit = np.stack([np.cos(angles), np.sin(angles), 0 * angles], -1)
    points = np.concatenate([unit * radii[0], unit * radii[1]]) + np.asarray(centre, float)
    faces = [(i, steps + 1 + i, steps + 2 + i, i + 1) for i in range(steps)]
    return mesh(name, points, faces, material)


def disc_down(name: str, centre: Point, radius: float, material: Any) -> Any:
    """A disc facing down."""
    angles = np.linspace(0.0, -2.0 * np.pi, 48, endpoint=False)
    points = np.stack([np.cos(angles), np.sin(angles), 0 * angles], -1) * radius + np.asarray(centre, float)
    return mesh(name, points, [range(48)], material)


def tube(name: str, ends: tuple[Point, Point], radii: tuple[float, float], material: Any) -> Any:
    """A round bar or a cone from one end to the other, with its caps."""
    start, end = (np.asarray(point, float) for point in ends)
    axis = (end - start) / np.linalg.norm(end - start)
    side = np.cross(axis, [1.0, 0.0, 0.0] if abs(axis[0]) < 0.9 else [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side)
    other = np.cross(axis, side)
    steps = 32
    angles = np.linspace(0.0, 2.0 * np.pi, steps, endpoint=False)[:, None]
    unit = np.cos(angles) * side + np.sin(angles) * other
    points = np.concatenate([start + radii[0] * unit, end + radii[1] * unit])
    around = [(i, (i + 1) % steps, steps + (i + 1) % steps, steps + i) for i in range(steps)]
    return mesh(name, points, [*around, range(steps - 1, -1, -1), range(steps, 2 * steps)], material)


def sphere(name: str, centre: Point, radius: float, material: Any) -> Any:
    """A sphere that Cycles intersects exactly: a point cloud of one point, not a mesh."""
    cloud = bpy.data.pointclouds.new(name)
    cloud.resize(1)
    cloud.points[0].co = (0.0, 0.0, 0.0)
    cloud.points[0].radius = radius
    cloud.materials.append(material)
    made = bpy.data.objects.new(name, cloud)
    made.location = tuple(centre)
    bpy.context.scene.collection.objects.link(made)
    return made
