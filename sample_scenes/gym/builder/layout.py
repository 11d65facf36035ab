"""Where things are: a hall of 28 x 16 x 9 m round the ball, which stands at (0, 0, 1.4). World +Y is the window side."""

from __future__ import annotations

from itertools import product

import numpy as np

WEST, EAST, SOUTH, NORTH, HEIGHT = -15.5, 12.5, -7.0, 9.0, 9.0
MIDDLE_X, MIDDLE_Y = (WEST + EAST) / 2, (SOUTH + NORTH) / 2
BALL_AT, BALL_RADIUS_M, CAMERA_DISTANCE_M = (0.0, 0.0, 1.4), 0.05, 0.8
LAMP_RADIUS_M, LAMP_HEIGHT_M = 0.6, 8.3
LAMPS_AT = [(x, y, LAMP_HEIGHT_M) for x, y in product((-12.0, -5.0, 2.0, 9.0), (-4.0, 1.0, 6.0))]
WINDOW_SIZE_M, SILL_M, WALL_M = (3.5, 3.8), 3.0, 0.35
WINDOWS_AT = [
    (x, NORTH + WALL_M, SILL_M + WINDOW_SIZE_M[1] / 2)
    for x in MIDDLE_X + np.array([-11, -6.6, -2.2, 2.2, 6.6, 11])
]

AZIMUTHS_DEG = (0, 120, 240)
PICTURE_PX = 480
FOCAL_MM, SENSOR_MM = 150.0, 22.0
FOCAL_PX = PICTURE_PX * FOCAL_MM / SENSOR_MM
PRINCIPAL_PX = (244.0, 237.5)
