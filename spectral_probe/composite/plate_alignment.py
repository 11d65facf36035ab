"""How the camera turned between a photograph of the ball and the plate, from what both show outside the ball.

A camera on a tripod hardly moves, yet a touch turns it by a pixel or more. A turn moves details that are near and far alike, so
it can be measured anywhere in the picture; a step aside cannot, and is told by details that disagree with any turn.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from ..errors import RenderError
from ..geometry.bundle import angle_between, rotation_of
from ..geometry.camera import pixel_rays, project
from ..model import BoolArray, Camera, FloatArray, Photograph
from ..photo.samples import linear_to_srgb

_LONGEST_PX = 2000
"""Details are looked for in pictures no larger than this: finer ones are noise and demosaicing."""

_FEATURES = 5000
_DISTINCT = 0.8
"""A match counts if it is this much nearer than the second nearest (Lowe's ratio)."""

_NEAR_PX = 3.0
"""Matches this far from a turn, in pixels of the smaller pictures, are taken for right while it is searched."""

_TRIALS = 600
_LEAST_MATCHES = 12
_ENOUGH_MATCHES = 40
"""With fewer, one of the pictures is out of focus, or there is little to see."""

_WIDTHS_PX = (400, 800)
"""Pictures without sharp detail in common are aligned at these widths, where moderate defocus is nothing."""

_SOFT_PX = 2.0
"""Blur at the first of these widths; what is wider than sixteen times it is left out, so that brightness does not matter."""

_DARK, _BRIGHT = 0.01, 0.9
"""Levels between which a picture's brightness is trusted, as shares of saturation."""

_LOOKS = 4

_ALIKE = 0.8
"""Correlation that such pictures must reach where they show the same."""

_UNLIKE, _CONTRAST = 0.4, 0.05
"""Below this correlation pictures whose logarithm of brightness varies by more than the second show different things."""

_MOST_TURN_RAD = np.radians(15.0)
"""A camera that turned by more was put up anew."""

_ROUNDS = 20
_ROUND_THE_BALL = 1.25
"""What lies within this many radii of the ball's centre is left out: the ball, its contact and its glow."""

_DEPENDENT = 4.0
"""How many matches count as one in errors: lens and demosaicing displace neighbours alike."""

_MOVED_ASIDE_PX = 1.5
"""Where details round the ball's place differ from the turn by more than this, the camera moved aside."""


@dataclass(frozen=True)
class PlateAlignment:
    """The turn of the camera from a photograph of the ball to the plate, and how well it is known.

    `turn` (3, 3) takes the photograph's camera coordinates to the plate's. `shift_px` (2,) is how far, (x, y), it moves the
    picture at the ball's place; `error_px` the standard error there; `rms_px` what the `used` of all `matches` details still
    differ by. `remarks` are sentences for the user.
    """

    turn: FloatArray
    shift_px: tuple[float, float]
    error_px: float
    rms_px: float
    used: int
    matches: int
    remarks: tuple[str, ...] = ()


def align_plate(
    photograph: Photograph,
    plate: Photograph,
    camera: Camera,
    ball_px: tuple[float, float, float],
    brighter: float = 1.0,
) -> PlateAlignment:
    """The turn of a camera between two photographs of one size.

    SIFT features [1]_ matched both ways; the rotation that most of them agree with (random pairs [2]_), then its least squares
    with Huber's weights. Where one of the pictures is out of focus and has no features in common with the other, both are
    blurred and aligned by correlation [3]_.

    Parameters
    ----------
    photograph, plate
        Where the ball stood in the picture, and where it is gone. Their brightness may differ.
    camera
        That took both, with its distortion.
    ball_px
        Centre x, y and radius of the ball in `photograph`.
    brighter
        Exposure of the plate over that of the photograph.

    Returns
    -------
    PlateAlignment
        The identity, with a remark, where the pictures show too little to tell.

    Raises
    ------
    RenderError
        If the plate shows another scene, or the same from elsewhere.

    References
    ----------
    .. [1] Lowe, D. G. (2004). Distinctive Image Features from Scale-Invariant Keypoints. IJCV 60(2).
       doi:10.1023/B:VISI.0000029664.99615.94
    .. [2] Fischler, M. A., & Bolles, R. C. (1981). Random Sample Consensus. CACM 24(6). doi:10.1145/358669.358692
    .. [3] Evangelidis, G. D., & Psarakis, E. Z. (2008). Parametric Image Alignment Using Enhanced Correlation Coefficient
       Maximization. IEEE TPAMI 30(10). doi:10.1109/TPAMI.2008.113
    """
    here, there = _matched_points(photograph, plate, ball_px)
    if len(here) < _ENOUGH_MATCHES:
        return _by_brightness(photograph, plate, camera, ball_px, brighter, len(here))
    rays, seen = pixel_rays(camera, here), pixel_rays(camera, there)
    scale = max(1.0, max(camera.size_px) / _LONGEST_PX)
    near_rad = _NEAR_PX * scale / max(camera.focal_px)
    turn, fits = _consensus(rays, seen, near_rad)
    used = int(fits.sum())
    if used < max(_LEAST_MATCHES, 0.1 * len(here)) or angle_between(turn, np.eye(3)) > _MOST_TURN_RAD:
        raise _another_scene(photograph, plate)
    turn, covariance = _refined(turn, rays[fits], seen[fits], near_rad / 3.0)
    centre = np.array(ball_px[:2])
    moved = project(camera, pixel_rays(camera, centre) @ turn.T) - centre
    left = project(camera, rays[fits] @ turn.T) - there[fits]
    error_px = float(np.sqrt(np.trace(covariance[:2, :2]) / 2.0) * max(camera.focal_px))
    return PlateAlignment(
        turn,
        (float(moved[0]), float(moved[1])),
        error_px,
        float(np.sqrt((left**2).sum(-1).mean() / 2.0)),
        used,
        len(here),
        _remarks(plate, here[fits], left, ball_px, used / len(here)),
    )


def _another_scene(photograph: Photograph, plate: Photograph) -> RenderError:
    return RenderError(
        f"{plate.path.name} shows another scene than {photograph.path.name}, or its camera stood elsewhere. Give a plate taken "
        "from the same place, or leave the alignment out."
    )


def _remarks(
    plate: Photograph, here: FloatArray, left: FloatArray, ball_px: tuple[float, float, float], share: float
) -> tuple[str, ...]:
    """What the user should know: above all, whether things near the ball moved otherwise than the rest."""
    x, y, radius = ball_px
    close = np.hypot(here[:, 0] - x, here[:, 1] - y) < 4.0 * radius
    if np.count_nonzero(close) >= _LEAST_MATCHES:
        aside = np.median(left[close], axis=0)
        if np.hypot(*aside) > _MOVED_ASIDE_PX:
            told = (
                f"The camera moved between the ball's photograph and {plate.path.name}, and not only turned: details round the "
                f"ball's place lie {np.hypot(*aside):.1f} px off. Use a tripod."
            )
            return (told,)
    if share < 0.3:
        told = f"Only {share:.0%} of the details in {plate.path.name} follow one turn of the camera."
        return (f"{told} Look at the alignment picture.",)
    return ()


# ---------------------------------------------------------------- details


def _matched_points(
    photograph: Photograph, plate: Photograph, ball_px: tuple[float, float, float]
) -> tuple[FloatArray, FloatArray]:
    """Points (N, 2) of both pictures that show the same detail, in pixels of the full size."""
    sift = cv2.SIFT_create(  # type: ignore[attr-defined]  # the stubs do not know it
        nfeatures=_FEATURES, contrastThreshold=0.02
    )
    found = []
    for picture, ball in ((photograph, ball_px), (plate, None)):
        small, seen, scale = _small_picture(picture)
        if ball is not None:
            centre = (round(ball[0] / scale[0]), round(ball[1] / scale[1]))
            cv2.circle(seen, centre, int(np.ceil(_ROUND_THE_BALL * ball[2] / min(scale))), 0, -1)
        points, descriptors = sift.detectAndCompute(small, seen)
        if descriptors is None or len(points) < 2:
            return np.zeros((0, 2)), np.zeros((0, 2))
        places = (np.array([point.pt for point in points]) + 0.5) * scale
        roots = np.sqrt(descriptors / np.maximum(descriptors.sum(1, keepdims=True), 1e-9))
        found.append((places, np.asarray(roots, np.float32)))
    (here, first), (there, second) = found
    matcher = cv2.BFMatcher(cv2.NORM_L2)
    forward = _distinct(matcher.knnMatch(first, second, k=2))
    backward = _distinct(matcher.knnMatch(second, first, k=2))
    pairs = [(one, other) for one, other in forward.items() if backward.get(other) == one]
    index = np.array(pairs, int).reshape(-1, 2)
    return here[index[:, 0]], there[index[:, 1]]


def _distinct(matches: object) -> dict[int, int]:
    """Matches that are clearly nearer than the second nearest, from one picture's numbers to the other's."""
    return {
        pair[0].queryIdx: pair[0].trainIdx
        for pair in matches  # type: ignore[attr-defined]  # OpenCV's stubs call it a Sequence of Sequence
        if len(pair) == 2 and pair[0].distance < _DISTINCT * pair[1].distance
    }


def _small_picture(
    photograph: Photograph, longest_px: int = _LONGEST_PX
) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.uint8], FloatArray]:
    """A grey picture (h, w) of 8 bits of usual brightness, where it is not clipped, and the full size over its own (x, y)."""
    height, width = photograph.clipped.shape
    factor = min(1.0, longest_px / max(height, width))
    size = (max(1, round(width * factor)), max(1, round(height * factor)))
    grey = photograph.pixels @ np.full(3, 1.0 / 3.0, np.float32)
    small = np.asarray(cv2.resize(grey, size, interpolation=cv2.INTER_AREA) if factor < 1.0 else grey)
    hidden = np.asarray(cv2.resize(photograph.clipped.astype(np.float32), size, interpolation=cv2.INTER_AREA))
    level = max(float(np.percentile(small, 98.0)), 1e-9)
    codes = np.clip(linear_to_srgb(small / level), 0.0, 1.0) * 255.0
    return (
        np.asarray(np.rint(codes), np.uint8),
        np.asarray((hidden < 0.5) * 255, np.uint8),
        np.array([width / size[0], height / size[1]]),
    )


# ---------------------------------------------------------------- the rotation


def _consensus(rays: FloatArray, seen: FloatArray, near_rad: float) -> tuple[FloatArray, BoolArray]:
    """The rotation, of those through random pairs, that takes most rays (N, 3) to what is seen, and which it does."""
    generator = np.random.default_rng(0)
    best: FloatArray = np.eye(3)  # a camera that stood still is tried first
    fits = _near(best, rays, seen, near_rad)
    for _ in range(_TRIALS):
        one, other = generator.choice(len(rays), 2, replace=False)
        turn = _turn_of_two(rays[[one, other]], seen[[one, other]])
        agree = _near(turn, rays, seen, near_rad)
        if agree.sum() > fits.sum():
            best, fits = turn, agree
    return best, fits


def _near(turn: FloatArray, rays: FloatArray, seen: FloatArray, near_rad: float) -> BoolArray:
    return np.asarray(np.linalg.norm(rays @ turn.T - seen, axis=-1) < near_rad)


def _turn_of_two(rays: FloatArray, seen: FloatArray) -> FloatArray:
    """The rotation (3, 3) that takes two rays (2, 3) to two others as nearly as it can (Kabsch)."""
    left, _, right = np.linalg.svd(seen.T @ rays)
    return np.asarray(left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right)


def _refined(
    turn: FloatArray, rays: FloatArray, seen: FloatArray, usual_rad: float
) -> tuple[FloatArray, FloatArray]:
    """Least squares with Huber's weights, and the covariance (3, 3) of the rotation vector in rad^2."""
    normal: FloatArray = np.eye(3)
    for _ in range(_ROUNDS):
        moved = rays @ turn.T
        rest = seen - moved
        size = np.linalg.norm(rest, axis=-1)
        spread = min(usual_rad, max(1.4826 * float(np.median(size)), 1e-9))
        weights = np.minimum(1.0, 1.5 * spread / np.maximum(size, 1e-12))
        # A small turn v moves a ray by v x ray; its normal equations are those of the matrices [ray]_x.
        squares = np.einsum("n,ni,nj->ij", weights, moved, moved)
        normal = np.eye(3) * float((weights * (moved**2).sum(-1)).sum()) - squares
        step = np.linalg.solve(normal, (weights[:, None] * np.cross(moved, rest)).sum(0))
        turn = rotation_of(step) @ turn
        if np.linalg.norm(step) < 1e-3 * usual_rad / np.sqrt(len(rays)):
            break
    variance = float((weights * size**2).sum() / max(float(weights.sum()), 1.0)) / 2.0
    return turn, np.asarray(np.linalg.inv(normal) * variance * _DEPENDENT)


# ---------------------------------------------------------------- pictures without sharp detail


def _by_brightness(
    photograph: Photograph,
    plate: Photograph,
    camera: Camera,
    ball_px: tuple[float, float, float],
    brighter: float,
    matches: int,
) -> PlateAlignment:
    """The turn between blurred pictures; what changed (the ball's support, its shadow) loses its say after a first look."""
    warp, shifts = np.eye(2, 3, dtype=np.float32), []
    centre = np.array(ball_px[:2])
    found: FloatArray = np.eye(3)
    for width in _WIDTHS_PX:
        scale = camera.size_px[0] / width
        here = _soft_picture(photograph, width, brighter)
        there = _soft_picture(plate, width, 1.0 / brighter)
        counted = np.full(here.shape, 255, np.uint8)
        at = (round(ball_px[0] / scale), round(ball_px[1] / scale))
        cv2.circle(counted, at, int(np.ceil(_ROUND_THE_BALL * ball_px[2] / scale)), 0, -1)
        clear = counted.copy()
        for _ in range(_LOOKS):
            warp, alike = _correlated(here, there, warp, counted)
            counted = np.where(_changed(here, there, warp), 0, clear).astype(np.uint8)
        if alike < _ALIKE:
            contrast = min(float(picture[counted > 0].std()) for picture in (here, there))
            if alike < _UNLIKE and contrast > _CONTRAST:
                raise _another_scene(photograph, plate)
            return _still(matches)
        found = _turn_of(warp, counted > 0, scale, camera)
        shifts.append(project(camera, pixel_rays(camera, centre) @ found.T) - centre)
        warp = warp.copy()
        warp[:, 2] *= _WIDTHS_PX[1] / _WIDTHS_PX[0]
    told = (
        f"{plate.path.name} and {photograph.path.name} share hardly any sharp detail: they were aligned by their blurred "
        "pictures."
    )
    apart = float(np.hypot(*(shifts[1] - shifts[0])))
    return PlateAlignment(found, (float(shifts[1][0]), float(shifts[1][1])), apart, 0.0, 0, matches, (told,))


def _soft_picture(photograph: Photograph, width: int, other: float) -> npt.NDArray[np.float32]:
    """The logarithm of brightness between two blur widths, (h, w), over the range that the other picture has as well.

    `other` is the exposure of the other picture over this one's.
    """
    height, full = photograph.clipped.shape
    size = (width, max(1, round(height * width / full)))
    grey = photograph.pixels @ np.full(3, 1.0 / 3.0, np.float32)
    small = np.asarray(cv2.resize(grey, size, interpolation=cv2.INTER_AREA))
    if photograph.scene_referred_float:
        small = small / max(float(np.percentile(small, 98.0)), 1e-9)
    lowest, highest = _DARK / min(other, 1.0), _BRIGHT / max(other, 1.0)
    logarithm = np.log(np.minimum(small, highest) + lowest)
    blur_px = _SOFT_PX * width / _WIDTHS_PX[0]
    fine, coarse = (cv2.GaussianBlur(logarithm, (0, 0), sigma) for sigma in (blur_px, 16.0 * blur_px))
    return np.asarray(fine - coarse, np.float32)


def _correlated(
    here: npt.NDArray[np.float32],
    there: npt.NDArray[np.float32],
    warp: npt.NDArray[np.float32],
    counted: npt.NDArray[np.uint8],
) -> tuple[npt.NDArray[np.float32], float]:
    """The shift and turn (2, 3) of a picture under which it correlates best with another, and how well."""
    criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 100, 1e-5)
    try:
        alike, warp = cv2.findTransformECC(
            here, there, warp.copy(), cv2.MOTION_EUCLIDEAN, criteria, counted, 1
        )
    except cv2.error:  # it does not converge where there is nothing to see
        return warp, 0.0
    return np.asarray(warp, np.float32), float(alike)


def _changed(
    here: npt.NDArray[np.float32], there: npt.NDArray[np.float32], warp: npt.NDArray[np.float32]
) -> BoolArray:
    """Where two aligned pictures differ far more than they usually do."""
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    moved = cv2.warpAffine(there, warp, here.shape[::-1], flags=flags)
    differ = np.abs(here - moved)
    return np.asarray(differ > max(6.0 * float(np.median(differ)), 0.02))


def _turn_of(warp: npt.NDArray[np.float32], counted: BoolArray, scale: float, camera: Camera) -> FloatArray:
    """The rotation of the camera that moves a picture as a small shift and turn of its plane do."""
    rows, columns = np.nonzero(counted)
    step = max(1, len(rows) // 2000)
    points = np.stack([columns, rows], axis=-1)[::step].astype(float)
    moved = points @ warp[:, :2].T.astype(float) + warp[:, 2]
    rays, seen = (pixel_rays(camera, (place + 0.5) * scale) for place in (points, moved))
    return _refined(np.eye(3), rays, seen, scale / max(camera.focal_px))[0]


def _still(matches: int) -> PlateAlignment:
    told = (
        "The plate has too little in common with the photograph of the ball to align them: the camera is taken to have stood "
        "still."
    )
    return PlateAlignment(np.eye(3), (0.0, 0.0), 0.0, 0.0, 0, matches, (told,))
