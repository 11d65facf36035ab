"""The pipeline on real photographs of mirrored balls: hand-held brackets, crops of different sizes, twenty views."""

import json

import numpy as np
import pytest

from spectral_probe.geometry.frames import view_angles
from spectral_probe.model import BallSettings, CameraSettings, Capture, ViewSettings, finish
from spectral_probe.probe import build_probe

pytestmark = pytest.mark.long

CHROME = BallSettings(0.05, "chrome")
WIDTH = 256
"""Of the panoramas: what is checked is the ball, the exposures and the poses, all found in the photographs themselves."""


@pytest.fixture(scope="module")
def photos(shared_dir):
    return shared_dir / "photos"


def check(probe, radii_px):
    """Every ball is found within 1 % of its radius or 2 pixels, the circles' own error; the panorama is whole and sane."""
    for view, radius_px in zip(probe.report["views"], radii_px, strict=True):
        assert np.mean(view["radius_px"]) == pytest.approx(radius_px, rel=0.01, abs=2)
    assert probe.report["blind_fraction"] < 0.25
    assert np.isfinite(probe.panorama.weights).all()
    assert probe.report["negative_fraction"] < 1e-4
    return probe


def test_living_room_whole_frames(photos):
    """Three exposures from a tripod with EXIF; the ball is 145 pixels across."""
    folder = photos / "bracket_a6400_livingroom"
    view = ViewSettings(tuple(folder / f"raw{number}.jpg" for number in (1, 2, 3)))
    probe = check(finish(build_probe(Capture((view,), ball=CHROME), WIDTH)), [72.5])
    assert "EXIF" in probe.report["views"][0]["focal_source"]
    assert probe.report["views"][0]["clipped_fraction"] < 0.02


def test_living_room_crops(photos):
    """The author's crops without EXIF: exposures and camera from the capture file."""
    folder = photos / "bracket_a6400_livingroom"
    view = ViewSettings(
        tuple(folder / f"rec{number}.jpg" for number in (1, 2, 3)), exposures_s=(1 / 10, 1 / 40, 1 / 160)
    )
    camera = CameraSettings(focal_px=(1264.0, 1264.0), principal_px=(67.6, 23.0))
    check(finish(build_probe(Capture((view,), camera, CHROME), WIDTH)), [73.0])


def test_office_crops_of_different_sizes(photos):
    """Five of eleven exposures, cropped by hand: no two of one size."""
    folder = photos / "bracket_a6000_office"
    times = (20, 80, 320, 1250, 4000)
    view = ViewSettings(tuple(folder / f"cp_t{time}.jpg" for time in times))
    camera = CameraSettings(focal_px=(4085.0, 4085.0), principal_px=(577.0, 894.0))
    probe = check(finish(build_probe(Capture((view,), camera, CHROME), WIDTH)), [718.0])
    assert probe.report["views"][0]["clipped_fraction"] < 0.01
    assert 5.0 < probe.report["views"][0]["distance_m"] / 0.05 < 6.6
    assert (
        np.abs(probe.report["views"][0]["exposure_offsets_ev"]).max() < 0.1
    )  # SOURCE.txt: they are consistent
    assert max(probe.report["views"][0]["response_residual_ev"]) < 0.1
    assert 0.0 < probe.report["views"][0]["moved_fraction"] < 0.05  # a head moved away


def test_office_whole_frames(photos):
    folder = photos / "bracket_a6000_office"
    view = ViewSettings(tuple(folder / f"t{time}.JPG" for time in (20, 320, 4000)))
    probe = check(finish(build_probe(Capture((view,), ball=CHROME), WIDTH)), [716.5])
    assert probe.report["views"][0]["centre_px"] == pytest.approx([3164, 1828], abs=9)


def lobby_views(photos, count):
    folder = photos / "multiview_mirrorball_lobby"
    data = json.loads((folder / "poses_by_us.json").read_text())
    views, radii = [], []
    poses = {name: pose for cluster in data["clusters"].values() for name, pose in cluster["views"].items()}
    present = [name for name in sorted(poses) if (folder / name).is_file()]
    for name in present[:: len(present) // count][:count]:
        rotation = np.array(poses[name]["R_cam_from_world"]).T
        azimuth, elevation, roll = view_angles(rotation)
        views.append(ViewSettings((folder / name,), azimuth, elevation, roll))
        radii.append(poses[name]["ball_fit_px"][2])
    camera = data["camera"]
    settings = CameraSettings(
        focal_px=(camera["f"],) * 2,
        principal_px=(camera["cx"], camera["cy"]),
        distortion=(camera["k1"], 0.0, 0.0, 0.0, 0.0),
    )
    return Capture(tuple(views), settings, CHROME), radii


def test_lobby_views_agree_with_each_other(photos):
    """Views from all around the ball, merged; poses come from the background alone and are up to 3 degrees off."""
    capture, radii = lobby_views(photos, 4)
    probe = check(finish(build_probe(capture, WIDTH)), radii)
    assert probe.report["blind_fraction"] < 0.03
    views = probe.report["views"]
    assert all(view["registered"] for view in views)
    assert np.median([view["registration_residual_deg"] for view in views]) < 1.0
    assert np.min([view["registration_correlation"] for view in views]) > 0.5
