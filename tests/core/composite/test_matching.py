"""A plate is matched to a probe: the camera's turn, the brightness, the place over the ground; what does not fit is refused."""

import json
import shutil
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from spectral_probe.composite.matching import MatchSettings, PlateMatch, match_plate
from spectral_probe.composite.plate_alignment import align_plate
from spectral_probe.composite.plate_geometry import (
    rendered_frame,
    undistorted,
    world_to_frame,
    world_to_plate,
)
from spectral_probe.composite.probe_views import MATCHING_KEY, ProbeView, view_table
from spectral_probe.errors import FileFormatError, PhotographError, RenderError
from spectral_probe.figures.alignment import alignment_picture, ball_outline
from spectral_probe.geometry.bundle import rotation_of
from spectral_probe.geometry.camera import pixel_rays, project
from spectral_probe.geometry.frames import camera_to_world
from spectral_probe.model import Camera, Exposure, FloatArray, finish
from spectral_probe.photo.read import read_photograph
from spectral_probe.photo.samples import linear_to_srgb

SIZE = (420, 280)
CAMERA = Camera((380.0, 392.0), (224.0, 131.0), SIZE, (-0.09, 0.02, 1e-3, -5e-4, 0.0))
BALL_M, RADIUS_M = np.array([0.03, 0.05, 0.8]), 0.06
TURN = rotation_of(np.array([0.004, -0.007, 0.003]))
"""Of the camera, before the plate: some three pixels."""


@dataclass(frozen=True)
class World:
    """Far things of random brightness, which a camera sees by the direction alone."""

    panorama: FloatArray

    def seen(self, turn: FloatArray) -> FloatArray:
        """Linear picture (H, W, 3) of the camera turned by a rotation (3, 3)."""
        points = np.stack(np.meshgrid(np.arange(SIZE[0]) + 0.5, np.arange(SIZE[1]) + 0.5), axis=-1)
        x, y, z = np.moveaxis(pixel_rays(CAMERA, points) @ turn, -1, 0)
        size = self.panorama.shape[0]
        places = (np.stack([x / z, y / z], -1) / 2.4 + 0.5) * size - 0.5
        return cv2.remap(self.panorama, places.astype(np.float32), None, cv2.INTER_CUBIC)


@pytest.fixture(scope="module")
def world() -> World:
    random = np.random.default_rng(3)
    fine, coarse = (random.standard_normal((1400, 1400)).astype(np.float32) for _ in range(2))
    detail = 6.0 * cv2.GaussianBlur(fine, (0, 0), 3.0) + 60.0 * cv2.GaussianBlur(coarse, (0, 0), 30.0)
    level = np.exp(-1.6 + 0.5 * detail)
    return World((level[..., None] * np.array([1.0, 0.9, 0.7])).astype(np.float32))


def with_ball(picture: FloatArray) -> FloatArray:
    x, y, radius = ball_circle()
    rows, columns = np.mgrid[: SIZE[1], : SIZE[0]] + 0.5
    return np.where((np.hypot(columns - x, rows - y) < radius)[..., None], 0.4, picture).astype(np.float32)


def ball_circle() -> tuple[float, float, float]:
    x, y = project(CAMERA, BALL_M)
    return float(x), float(y), float(RADIUS_M / np.linalg.norm(BALL_M) * CAMERA.focal_px[0])


def photographed(path: Path, linear: FloatArray) -> Path:
    """A converted picture of linear light, as PNG."""
    Image.fromarray(np.rint(255 * linear_to_srgb(np.clip(linear, 0, 1))).astype(np.uint8)).save(path)
    return path


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory, world: World) -> Path:
    """A probe's folder with a report of one view that looks down by 20 degrees, exposed for 0.01 and 0.04."""
    folder = tmp_path_factory.mktemp("probe")
    photographed(folder / "plate.png", world.seen(TURN) * 2.0 * np.array([1.1, 1.0, 0.9]))
    scene = with_ball(world.seen(np.eye(3)))
    photos = [
        photographed(folder / f"ball_{number}.png", scene * scale) for number, scale in ((0, 1.0), (1, 4.0))
    ]
    return report(
        folder,
        ProbeView(
            photos=tuple(photos),
            camera=CAMERA,
            half_size=False,
            rotation=camera_to_world(0.0, 20.0),
            ball_centre_m=BALL_M,
            ball_radius_m=RADIUS_M,
            outline_px=ball_circle(),
            shifts_px=np.zeros((2, 2)),
            exposures=(0.01, 0.04),
            converted=True,
            response_log_gain=np.zeros((3, 25)),
            gain=np.ones(3),
            camera_model="Rec.709",
            sensitivities=None,
        ),
    )


def report(folder: Path, view: ProbeView) -> Path:
    (folder / "report.json").write_text(json.dumps({"views": [{MATCHING_KEY: view_table(view, folder)}]}))
    return folder


@pytest.fixture
def probe(built: Path, tmp_path: Path) -> Path:
    """The same as a copy that a test may change."""
    return Path(shutil.copytree(built, tmp_path / "probe"))


@pytest.fixture
def plate(built: Path) -> Path:
    """Turned by TURN, twice as exposed as the first photograph, with a warmer white balance."""
    return built / "plate.png"


@pytest.fixture(scope="module")
def found(built: Path) -> PlateMatch:
    return matched(built, built / "plate.png")


SETTINGS = MatchSettings(exposure=Exposure(0.02))


def matched(probe: Path, plate: Path, settings: MatchSettings = SETTINGS) -> PlateMatch:
    return finish(match_plate(probe, plate, settings))


def test_the_turn_of_the_camera_is_found_to_a_tenth_of_a_pixel(found: PlateMatch) -> None:
    assert found.alignment is not None
    points = np.array([[40.0, 30.0], [380.0, 40.0], [60.0, 250.0], [370.0, 240.0], [220.0, 140.0]])
    rays = pixel_rays(CAMERA, points)
    moved = project(CAMERA, rays @ found.alignment.turn.T) - project(CAMERA, rays @ TURN.T)
    assert np.abs(moved).max() < 0.1
    assert np.hypot(*(project(CAMERA, rays[4] @ TURN.T) - points[4])) > 2.0  # and there was something to find
    assert found.alignment.used > 100
    assert found.alignment.error_px < 0.05


def test_brightness_and_balance_are_measured_and_told(found: PlateMatch) -> None:
    np.testing.assert_allclose(found.gain, [1.1, 1.0, 0.9], rtol=0.01)
    np.testing.assert_array_equal(found.gain, found.backplate.gain)
    assert any("white balance" in remark for remark in found.remarks)


def test_equal_brightness_is_taken_for_equal(probe: Path, tmp_path: Path, world: World) -> None:
    plate = photographed(tmp_path / "plate.png", world.seen(np.eye(3)) * 2.0)
    found = matched(probe, plate, replace(SETTINGS, align=False))
    np.testing.assert_array_equal(found.backplate.gain, np.ones(3))
    assert found.remarks == ()


def test_an_exposure_that_is_not_stated_is_measured(probe: Path, plate: Path) -> None:
    found = matched(probe, plate, MatchSettings())
    product = found.backplate.exposure * found.backplate.gain
    np.testing.assert_allclose(product, 0.02 * np.array([1.1, 1.0, 0.9]), rtol=0.02)
    assert any("no exposure time" in remark for remark in found.remarks)


def test_a_plate_out_of_focus_is_aligned_to_half_a_pixel(probe: Path, tmp_path: Path, world: World) -> None:
    soft = cv2.GaussianBlur(world.seen(TURN), (0, 0), 6.0)
    plate = photographed(tmp_path / "plate.png", soft * 2.0)
    found = matched(probe, plate)
    assert found.alignment is not None
    centre = np.array(ball_circle()[:2])
    expected = project(CAMERA, pixel_rays(CAMERA, centre) @ TURN.T) - centre
    np.testing.assert_allclose(found.alignment.shift_px, expected, atol=0.5)


def test_the_ball_is_where_it_was_photographed_and_stands_on_the_ground(found: PlateMatch) -> None:
    backplate = found.backplate
    assert backplate.ball_centre_m is not None
    np.testing.assert_allclose(backplate.ball_centre_m, [0.0, 0.0, RADIUS_M])
    turned = project(CAMERA, BALL_M @ TURN.T)
    np.testing.assert_allclose(world_to_plate(backplate, backplate.ball_centre_m), turned, atol=0.1)
    rim = pixel_rays(backplate.camera, ball_outline(backplate))
    axis = BALL_M @ TURN.T / np.linalg.norm(BALL_M)
    np.testing.assert_allclose(np.arccos(rim @ axis), np.arcsin(RADIUS_M / np.linalg.norm(BALL_M)), atol=3e-4)


def test_a_photograph_of_the_ball_itself_needs_no_alignment(probe: Path) -> None:
    found = matched(probe, probe / "ball_1.png", MatchSettings(exposure=Exposure(0.04)))
    assert found.alignment is None
    assert found.remarks == ()
    np.testing.assert_allclose(found.backplate.gain, np.ones(3))
    assert found.backplate.ball_centre_m is not None
    seen = world_to_plate(found.backplate, found.backplate.ball_centre_m)
    np.testing.assert_allclose(seen, ball_circle()[:2], atol=1e-3)


def test_the_ground_may_lie_lower(probe: Path, plate: Path) -> None:
    level, below = (
        matched(probe, plate, replace(SETTINGS, align=False, ground_below_m=metres)).backplate
        for metres in (None, 0.2)
    )
    np.testing.assert_allclose(below.position_m - level.position_m, [0.0, 0.0, 0.2 - RADIUS_M])


def test_a_smaller_plate_shows_the_same(probe: Path, plate: Path) -> None:
    whole, half = (
        matched(probe, plate, replace(SETTINGS, align=False, width_px=width)).backplate
        for width in (None, 210)
    )
    points = np.random.default_rng(0).uniform(-0.1, 0.1, (9, 3))
    np.testing.assert_allclose(world_to_plate(half, points), world_to_plate(whole, points) / 2)
    assert half.camera.size_px == (210, 140)
    assert half.photo_size_px == SIZE


def test_the_frame_holds_the_whole_bent_picture(probe: Path, plate: Path) -> None:
    backplate = matched(probe, plate, replace(SETTINGS, align=False)).backplate
    left, top, width, height = backplate.frame_px
    assert backplate.frame_px == rendered_frame(CAMERA)
    assert left < 0
    assert top < 0
    assert width > SIZE[0]
    assert height > SIZE[1]
    point = np.array([0.05, 0.1, 0.02])
    marked = np.zeros(SIZE[::-1], np.float32)
    x, y = world_to_plate(backplate, point)
    cv2.circle(marked, (round(x * 16 - 8), round(y * 16 - 8)), 4 * 16, 1.0, -1, cv2.LINE_AA, 4)
    straight = undistorted(marked, backplate)
    rows, columns = np.mgrid[:height, :width] + 0.5
    centre = np.array([(straight * columns).sum(), (straight * rows).sum()]) / straight.sum()
    np.testing.assert_allclose(centre, world_to_frame(backplate, point), atol=0.2)


def test_the_alignment_picture_turns_the_photograph_of_the_ball_to_the_plate(found: PlateMatch) -> None:
    picture = alignment_picture(found, 0.5).astype(float)
    first, second = picture[:, : SIZE[0]], picture[:, SIZE[0] :]
    above = (slice(10, 70), slice(20, -20))  # the ball and the ground
    likeness = np.corrcoef(first[above][..., 1].ravel(), second[above][..., 1].ravel())[0, 1]
    assert likeness > 0.98  # 0.5 without the turn


@pytest.mark.parametrize("other", ["mirrored", "turned"])
def test_another_scene_is_refused(probe: Path, tmp_path: Path, world: World, other: str) -> None:
    here = world.seen(np.eye(3))
    there = here[:, ::-1] if other == "mirrored" else here[::-1, ::-1]
    plate = photographed(tmp_path / "plate.png", there)
    with pytest.raises(RenderError, match="shows another scene"):
        align_plate(read_photograph(probe / "ball_0.png"), read_photograph(plate), CAMERA, ball_circle())


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"view": 2}, "no view 2"),
        ({"width_px": 5000}, "420 pixels wide"),
        ({"ground_below_m": 0.01}, "cannot lie 0.01 m below"),
        ({"exposure": Exposure(1e9)}, "cannot be"),
    ],
)
def test_settings_that_cannot_be_are_refused(
    probe: Path, plate: Path, changed: dict[str, object], message: str
) -> None:
    with pytest.raises((RenderError, PhotographError), match=message):
        matched(probe, plate, replace(SETTINGS, align=False, **changed))


def test_a_plate_of_another_size_is_refused(probe: Path, tmp_path: Path) -> None:
    plate = photographed(tmp_path / "plate.png", np.full((280, 300, 3), 0.2))
    with pytest.raises(RenderError, match="300 x 280 pixels, the photographs of the ball 420 x 280"):
        matched(probe, plate)


def changed_view(probe: Path, **changes: object) -> Path:
    from spectral_probe.composite.probe_views import read_probe_views

    return report(probe, replace(read_probe_views(probe)[0], **changes))


def test_a_converted_plate_of_a_raw_capture_needs_a_response(probe: Path, plate: Path) -> None:
    changed_view(probe, converted=False, response_log_gain=None, camera_model="Nikon 5100 (NPL)")
    with pytest.raises(RenderError, match="response curve is missing"):
        matched(probe, plate)
    found = matched(probe, plate, replace(SETTINGS, srgb=True, align=False)).backplate
    assert (found.camera_model, found.response_log_gain) == ("Rec.709", None)


def test_a_camera_below_the_ground_is_refused(probe: Path, plate: Path) -> None:
    changed_view(probe, rotation=camera_to_world(0.0, -30.0), photos=(Path("gone.png"),) * 2)
    with pytest.raises(RenderError, match="below the ground"):
        matched(probe, plate)


def test_photographs_that_are_gone_are_told(probe: Path, plate: Path) -> None:
    (probe / "ball_0.png").unlink()
    (probe / "ball_1.png").unlink()
    found = matched(probe, plate)
    assert found.alignment is None
    assert "no longer where" in found.remarks[0]
    with pytest.raises(PhotographError, match="no exposure time"):
        matched(probe, plate, MatchSettings())


def test_a_missing_and_an_older_report_are_refused(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match="There is no report"):
        matched(tmp_path, tmp_path / "plate.png")
    (tmp_path / "report.json").write_text('{"views": [{"photos": []}]}')
    with pytest.raises(FileFormatError, match="Build the probe again"):
        matched(tmp_path, tmp_path / "plate.png")
