"""The gym in Blender: the hall and what is in it, the ball on its stand, the photographer."""

from __future__ import annotations

from itertools import pairwise, product
from typing import Any

import numpy as np

from .layout import (
    BALL_AT,
    BALL_RADIUS_M,
    EAST,
    HEIGHT,
    LAMP_RADIUS_M,
    LAMPS_AT,
    MIDDLE_X,
    MIDDLE_Y,
    NORTH,
    SILL_M,
    SOUTH,
    WALL_M,
    WEST,
    WINDOW_SIZE_M,
    WINDOWS_AT,
)
from .materials import SpectralMaterials, emitter
from .shapes import box, disc_down, rectangle, ring, sphere, tube


def build_hall(materials: SpectralMaterials) -> None:
    """Everything but the ball, its stand and the camera."""
    _shell(materials)
    _windows(materials)
    _lamps_and_beams(materials)
    _court(materials)
    for end, towards in ((WEST, 1.0), (EAST, -1.0)):
        _basket(materials, end, towards)
        _mats(materials, end, towards)
    _south_wall(materials)
    _things(materials)


def _shell(m: SpectralMaterials) -> None:
    length, width = EAST - WEST, NORTH - SOUTH
    floor = m.boards("maple", "maple dark", (1.9, 0.11), roughness=0.28)
    rectangle("floor", (MIDDLE_X, MIDDLE_Y, 0), (length / 2, 0, 0), (0, width / 2, 0), floor)
    rectangle(
        "ceiling", (MIDDLE_X, MIDDLE_Y, HEIGHT), (length / 2, 0, 0), (0, -width / 2, 0), m.paint("ceiling")
    )
    wall = m.paint("wall")
    rectangle("south wall", (MIDDLE_X, SOUTH, HEIGHT / 2), (-length / 2, 0, 0), (0, 0, HEIGHT / 2), wall)
    rectangle("west wall", (WEST, MIDDLE_Y, HEIGHT / 2), (0, width / 2, 0), (0, 0, HEIGHT / 2), wall)
    rectangle("east wall", (EAST, MIDDLE_Y, HEIGHT / 2), (0, -width / 2, 0), (0, 0, HEIGHT / 2), wall)
    oak = m.boards("oak", "maple dark", (2.4, 0.16), roughness=0.4, upright=True)
    for y, inwards in ((NORTH, -1.0), (SOUTH, 1.0)):
        box("wainscot", (MIDDLE_X, y + 0.02 * inwards, 1.1), (length, 0.04, 2.2), oak)
        box("rail", (MIDDLE_X, y + 0.03 * inwards, 2.23), (length, 0.06, 0.06), m.paint("beech"))


def _windows(m: SpectralMaterials) -> None:
    wall, frame = m.paint("wall"), m.paint("neutral 3.5 (1.05 D)")
    width, height = WINDOW_SIZE_M
    top, y = SILL_M + height, NORTH + WALL_M / 2
    length = EAST - WEST
    box("wall below the windows", (MIDDLE_X, y, SILL_M / 2), (length, WALL_M, SILL_M), wall)
    box("wall above the windows", (MIDDLE_X, y, (top + HEIGHT) / 2), (length, WALL_M, HEIGHT - top), wall)
    edges = [WEST, *(x + s * width / 2 for x, _, _ in WINDOWS_AT for s in (-1, 1)), EAST]
    for left, right in zip(edges[::2], edges[1::2], strict=True):
        box("pier", ((left + right) / 2, y, SILL_M + height / 2), (right - left, WALL_M, height), wall)
    sky = emitter("window", clouds=True)
    for x, glass_y, z in WINDOWS_AT:
        pane = rectangle("window", (x, glass_y, z), (width / 2, 0, 0), (0, 0, height / 2), sky)
        pane.lightgroup = "windows"
        for step in (-1.0, -1 / 3, 1 / 3, 1.0):
            bar_x = x + step * (width / 2 - 0.04)
            box("mullion", (bar_x, glass_y - 0.05, z), (0.08, 0.08, height), frame)
        for step in (-1.0, 0.3, 1.0):
            bar_z = z + step * (height / 2 - 0.04)
            box("transom", (x, glass_y - 0.05, bar_z), (width, 0.08, 0.08), frame)


def _lamps_and_beams(m: SpectralMaterials) -> None:
    steel, glow = m.paint("steel"), emitter("lamp")
    for x, y, z in LAMPS_AT:
        disc_down("lamp", (x, y, z), LAMP_RADIUS_M, glow).lightgroup = "lamps"
        tube(
            "lamp housing",
            ((x, y, z + 0.005), (x, y, z + 0.20)),
            (LAMP_RADIUS_M + 0.03, 0.38),
            m.paint("neutral 5 (.70 D)"),
        )
        tube("lamp rod", ((x, y, z + 0.2), (x, y, HEIGHT)), (0.03, 0.03), steel)
    for x in np.arange(WEST + 1.75, EAST, 3.5):
        box("beam", (x, MIDDLE_Y, HEIGHT - 0.2), (0.22, NORTH - SOUTH, 0.4), steel)
    for y in (-1.5, 3.5):
        box("purlin", (MIDDLE_X, y, HEIGHT - 0.08), (EAST - WEST, 0.12, 0.16), steel)


def _line(name: str, centre: tuple[float, float], size: tuple[float, float], z: float, material: Any) -> None:
    rectangle(name, (*centre, z), (size[0] / 2, 0, 0), (0, size[1] / 2, 0), material)


def _frame(
    name: str, centre: tuple[float, float], size: tuple[float, float], z: float, material: Any
) -> None:
    width = 0.06
    for s in (-1, 1):
        _line(name, (centre[0], centre[1] + s * size[1] / 2), (size[0] + width, width), z, material)
        _line(name, (centre[0] + s * size[0] / 2, centre[1]), (width, size[1] + width), z, material)


def _court(m: SpectralMaterials) -> None:
    white, blue, green = m.paint("white 9.5 (.05 D)"), m.paint("blue"), m.paint("green")
    court = (25.0, 13.4)
    _frame("basketball court", (MIDDLE_X, MIDDLE_Y), court, 0.004, white)
    _line("half-way line", (MIDDLE_X, MIDDLE_Y), (0.06, court[1]), 0.004, white)
    ring("centre circle", (MIDDLE_X, MIDDLE_Y, 0.0035), (0.0, 1.77), m.paint("moderate red"))
    ring("centre circle", (MIDDLE_X, MIDDLE_Y, 0.005), (1.77, 1.83), white)
    _frame("volleyball court", (MIDDLE_X, MIDDLE_Y), (18.0, 9.0), 0.003, blue)
    _frame("badminton court", (MIDDLE_X + 4.5, MIDDLE_Y + 0.4), (13.4, 6.1), 0.002, green)
    for s in (-1.0, 1.0):
        end = MIDDLE_X + s * court[0] / 2
        _line("key", (end - s * 2.9, MIDDLE_Y), (5.8, 4.9), 0.0015, m.paint("moderate red"))
        _frame("key", (end - s * 2.9, MIDDLE_Y), (5.8, 4.9), 0.005, white)
        arc = (90.0, 270.0) if s > 0 else (-90.0, 90.0)
        ring("free throw", (end - s * 5.8, MIDDLE_Y, 0.005), (1.77, 1.83), white, arc)
        arc3 = (101.0, 259.0) if s > 0 else (-79.0, 79.0)
        ring("three points", (end - s * 1.575, MIDDLE_Y, 0.005), (6.05, 6.11), white, arc3)


def _basket(m: SpectralMaterials, end: float, towards: float) -> None:
    board_x = end + towards * 1.9
    white, steel = m.paint("white 9.5 (.05 D)"), m.paint("steel")
    box("backboard", (board_x, MIDDLE_Y, 3.45), (0.05, 1.8, 1.05), white)
    front = board_x + towards * 0.03
    for dy, dz, wide, high in (
        (0, 0.1, 0.59, 0.05),
        (0, -0.30, 0.59, 0.05),
        (-0.27, -0.1, 0.05, 0.45),
        (0.27, -0.1, 0.05, 0.45),
    ):
        box("square on the board", (front, MIDDLE_Y + dy, 3.4 + dz), (0.01, wide, high), m.paint("red"))
    for dy in (-0.88, 0.88):
        box(
            "edge of the board", (front, MIDDLE_Y + dy, 3.45), (0.012, 0.06, 1.05), m.paint("black 2 (1.5 D)")
        )
    for dy in (-0.5, 0.5):
        ends = ((end, MIDDLE_Y + 1.6 * dy, 4.2), (board_x - towards * 0.03, MIDDLE_Y + dy, 3.6))
        tube("arm", ends, (0.04, 0.04), steel)
    hoop = (board_x + towards * 0.4, MIDDLE_Y, 3.05)
    angles = np.linspace(0, 2 * np.pi, 25)
    points = [(hoop[0] + 0.225 * np.cos(a), hoop[1] + 0.225 * np.sin(a), hoop[2]) for a in angles]
    for start, stop in pairwise(points):
        tube("hoop", (start, stop), (0.018, 0.018), m.paint("orange"))
    for a in angles[::2]:
        rim = (hoop[0] + 0.225 * np.cos(a), hoop[1] + 0.225 * np.sin(a), hoop[2])
        low = (hoop[0] + 0.13 * np.cos(a + 0.5), hoop[1] + 0.13 * np.sin(a + 0.5), hoop[2] - 0.42)
        tube("net", (rim, low), (0.008, 0.008), white)


def _mats(m: SpectralMaterials, end: float, towards: float) -> None:
    colours = ("blue", "purplish blue") if towards > 0 else ("red", "orange yellow")
    for i, y in enumerate(np.arange(SOUTH + 1.0, NORTH - 0.5, 2.0)):
        box("wall mat", (end + towards * 0.05, y, 1.05), (0.1, 1.94, 2.0), m.paint(colours[i % 2]))


def _south_wall(m: SpectralMaterials) -> None:
    beech, y = m.paint("beech"), SOUTH + 0.06
    for section in range(5):
        left = -9.2 + section * 1.0
        for x in (left, left + 0.95):
            box("wall bar post", (x, y + 0.06, 1.4), (0.05, 0.12, 2.8), beech)
        for z in np.arange(0.25, 2.8, 0.18):
            bar = ((left, y + 0.12, z), (left + 0.95, y + 0.12, z))
            tube("wall bar", bar, (0.02, 0.02), beech)
    for x in (-1.4, -0.35):
        box("door", (x, y, 1.1), (1.0, 0.1, 2.2), m.paint("bluish green"))
        box("door glass", (x, y + 0.03, 1.6), (0.4, 0.08, 0.5), m.paint("neutral 3.5 (1.05 D)"))
    for x, wide in ((-1.95, 0.1), (0.2, 0.1)):
        box("door frame", (x, y + 0.03, 1.13), (wide, 0.16, 2.3), m.paint("neutral 5 (.70 D)"))
    box("score board", (4.5, SOUTH + 0.08, 5.6), (3.0, 0.16, 1.3), m.paint("black 2 (1.5 D)"))
    for x, paint in ((3.6, "orange"), (5.4, "orange"), (4.5, "yellow green")):
        box("score", (x, SOUTH + 0.17, 5.6), (0.5, 0.02, 0.6), m.paint(paint))
    flags = ("red", "yellow", "purplish blue", "foliage", "magenta", "cyan", "orange", "purple")
    for i, paint in enumerate(flags):
        box("banner", (-13.6 + 1.5 * i, SOUTH + 0.06, 5.9), (0.95, 0.03, 2.2), m.paint(paint))


def _bench(m: SpectralMaterials, x: float, y: float, turn_deg: float = 0.0) -> None:
    box("bench", (x, y, 0.42), (2.8, 0.28, 0.05), m.paint("beech"), turn_deg)
    turn = np.radians(turn_deg)
    for step in (-1.1, 1.1):
        at = (x + step * np.cos(turn), y + step * np.sin(turn), 0.2)
        box("bench leg", at, (0.06, 0.26, 0.4), m.paint("neutral 3.5 (1.05 D)"), turn_deg)


def _things(m: SpectralMaterials) -> None:
    for x in (-12.0, 4.0, 8.0):
        _bench(m, x, SOUTH + 0.55)
    _bench(m, 3.2, 8.3)
    _bench(m, -6.0, 8.3)
    for i, paint in enumerate(("blue", "bluish green", "blue")):
        box("soft mat", (-4.6, 4.6, 0.15 + 0.3 * i), (3.0, 2.0, 0.28), m.paint(paint), 12.0 + 2 * i)
    box("exercise mat", (3.4, -2.9, 0.03), (2.0, 1.0, 0.05), m.paint("cyan"), -20.0)
    for i in range(4):
        size = 1.5 - 0.06 * i
        box("vaulting box", (6.3, 3.6, 0.16 + 0.3 * i), (size, 0.8 - 0.08 * i, 0.28), m.paint("maple"), 35.0)
    box("vaulting box top", (6.3, 3.6, 1.33), (1.3, 0.5, 0.14), m.paint("dark skin"), 35.0)
    for x, y in ((1.7, 2.9), (2.3, 3.3), (-2.3, -2.6)):
        sphere("basketball", (x, y, 0.125), 0.12, m.paint("orange"))
    sphere("volleyball", (-3.0, 2.2, 0.105), 0.105, m.paint("yellow"))
    sphere("gymnastics ball", (2.6, -1.3, 0.1), 0.095, m.paint("moderate red"))
    for x, y in ((-2.4, 0.9), (-3.6, -1.2)):
        tube("training cone", ((x, y, 0.0), (x, y, 0.35)), (0.13, 0.02), m.paint("orange yellow"))
    _trolley(m, 5.0, -4.6)


def _trolley(m: SpectralMaterials, x: float, y: float) -> None:
    for dx, dy in product((-0.6, 0.6), (-0.3, 0.3)):
        tube("trolley", ((x + dx, y + dy, 0.0), (x + dx, y + dy, 1.0)), (0.02, 0.02), m.paint("steel"))
    for row, (height, paint) in enumerate(((0.42, "orange"), (0.80, "white 9.5 (.05 D)"))):
        box("trolley shelf", (x, y, height - 0.14), (1.25, 0.6, 0.03), m.paint("steel"))
        for i in range(4):
            sphere(
                "ball on the trolley",
                (x - 0.42 + 0.28 * i, y + 0.05 * (-1) ** (i + row), height),
                0.12,
                m.paint(paint),
            )


def build_ball(materials: SpectralMaterials) -> list[Any]:
    """The mirrored ball and its stand; returned so that they can be hidden for the truth."""
    x, y, z = BALL_AT
    dark = materials.paint("neutral 3.5 (1.05 D)")
    stand = tube("stand", ((x, y, 0.02), (x, y, z - BALL_RADIUS_M + 0.001)), (0.004, 0.004), dark)
    foot = tube("foot", ((x, y, 0.0), (x, y, 0.02)), (0.16, 0.16), dark)
    return [sphere("mirrored ball", BALL_AT, BALL_RADIUS_M, materials.mirror_ball()), stand, foot]


def build_photographer(materials: SpectralMaterials) -> Any:
    """The camera on its tripod and the person behind it, all children of an empty at the camera's pinhole looking along +Y."""
    import bpy

    m = materials
    black, grey = m.paint("black 2 (1.5 D)"), m.paint("neutral 3.5 (1.05 D)")
    root = bpy.data.objects.new("photographer", None)
    bpy.context.scene.collection.objects.link(root)
    z = BALL_AT[2]
    parts = [
        tube("lens", ((0, -0.004, z), (0, -0.16, z)), (0.036, 0.034), black),
        box("camera", (0, -0.20, z - 0.005), (0.135, 0.075, 0.10), black),
        box("viewfinder", (0, -0.20, z + 0.06), (0.06, 0.06, 0.04), black),
        tube("tripod head", ((0, -0.20, z - 0.16), (0, -0.20, z - 0.05)), (0.03, 0.03), grey),
    ]
    for angle in np.radians((90, 210, 330)):
        foot = (0.38 * np.cos(angle), -0.20 + 0.38 * np.sin(angle), 0.0)
        parts.append(tube("tripod leg", ((0, -0.20, z - 0.16), foot), (0.018, 0.012), grey))
    parts.extend(_person(m, 0.16, -0.62))
    for part in parts:
        part.parent = root
    return root


def _person(m: SpectralMaterials, x: float, y: float) -> list[Any]:
    jacket, jeans, skin = m.paint("purple"), m.paint("purplish blue"), m.paint("light skin")
    parts = [
        tube("torso", ((x, y, 0.88), (x, y, 1.42)), (0.16, 0.20), jacket),
        tube("shoulders", ((x, y, 1.42), (x, y, 1.50)), (0.20, 0.07), jacket),
        tube("neck", ((x, y, 1.48), (x, y, 1.58)), (0.055, 0.055), skin),
        sphere("head", (x, y, 1.66), 0.115, skin),
        sphere("hair", (x, y - 0.025, 1.685), 0.115, m.paint("dark skin")),
    ]
    for side in (-1, 1):
        hip, foot = (x + 0.09 * side, y, 0.92), (x + 0.11 * side, y, 0.0)
        parts.append(tube("leg", (foot, hip), (0.065, 0.09), jeans))
        elbow, hand = (x + 0.30 * side, y + 0.05, 1.13), (x - 0.10 + 0.12 * side, y + 0.34, 1.33)
        parts.append(tube("upper arm", ((x + 0.19 * side, y, 1.43), elbow), (0.055, 0.05), jacket))
        parts.append(tube("forearm", (elbow, hand), (0.05, 0.035), jacket))
        parts.append(sphere("hand", hand, 0.045, skin))
    return parts
