"""The whole pipeline from photographs to a panorama, against a simulated capture whose truth is known."""

import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import OpenEXR
import pytest

from spectral_probe.errors import CaptureError
from spectral_probe.files.capture import load_capture
from spectral_probe.files.probe_exr import read_layers, read_probe
from spectral_probe.model import Capture, finish
from spectral_probe.probe import build_probe, write_outputs


@pytest.fixture(scope="module")
def gym(shared_dir, tmp_path_factory):
    """A probe of the simulated gym, built and written once."""
    folder = tmp_path_factory.mktemp("gym")
    probe = finish(build_probe(load_capture(shared_dir / "captures" / "gym" / "capture.toml"), width=512))
    finish(write_outputs(probe, folder))
    return folder


@pytest.fixture(scope="module")
def score(gym, shared_dir):
    command = [
        sys.executable,
        shared_dir / "tools" / "score_probe.py",
        shared_dir / "captures" / "gym" / "truth",
        gym,
        "--json",
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


def test_lamps_are_where_they_are(score):
    assert (
        score["lamp_direction_deg"]["median"] <= 0.3
    )  # half a texel of this small panorama; 0.09 at a width of 1024
    assert score["lamp_direction_deg"]["max"] <= 0.6


@pytest.mark.parametrize("region", ["lamps", "windows"])
def test_lights_have_their_spectra(score, region):
    assert score[region]["gfc_median"] >= 0.9995
    assert score[region]["dE_light_median"] <= 0.6


def test_everything_else_has_its_spectrum(score):
    assert score["everything else"]["gfc_median"] >= 0.9955
    assert score["everything else"]["dE_light_median"] <= 0.65
    assert score["everything else"]["negative_fraction"] == 0


def test_the_ball_is_found_within_a_seventh_of_a_pixel(gym):
    radius_px = 5720.267 * np.tan(np.arcsin(0.05 / 0.8))
    for view in json.loads((gym / "report.json").read_text())["views"]:
        assert view["centre_px"] == pytest.approx([400, 400], abs=0.15)
        assert view["radius_px"] == pytest.approx([radius_px] * 2, abs=0.15)
        assert view["distance_m"] == pytest.approx(0.8, rel=1e-3)


def test_exact_angles_are_left_alone_and_registration_is_reported(gym):
    report = json.loads((gym / "report.json").read_text())
    for view, azimuth in zip(report["views"], (0, 120, 240), strict=True):
        assert view["azimuth_deg"] == pytest.approx(azimuth, abs=0.1)
        assert view["nominal_azimuth_deg"] == azimuth
        assert (view["elevation_deg"], view["roll_deg"]) == pytest.approx((0, 0), abs=0.15)
        assert view["registered"]
        assert view["registration_residual_deg"] < 0.4
        assert view["gain"] == pytest.approx([1, 1, 1], abs=0.01)
    (said,) = report["warnings"]
    assert "Nikon 5100 (NPL) are normalised channel by channel" in said


def test_wrong_angles_are_refined(shared_dir):
    """An azimuth 3 degrees wrong, elevation 1 and roll 2: back within 0.1 degree of azimuth, in a room 14 by 24 m."""
    capture = load_capture(shared_dir / "captures" / "gym" / "capture.toml")
    wrong = [(0, 0, 0), (123, 1, -2)]
    views = tuple(
        replace(view, azimuth_deg=azimuth, elevation_deg=elevation, roll_deg=roll)
        for view, (azimuth, elevation, roll) in zip(capture.views, wrong, strict=False)
    )
    report = finish(build_probe(replace(capture, views=views), width=128)).report
    for view, azimuth in zip(report["views"], (0, 120), strict=True):
        assert view["azimuth_deg"] == pytest.approx(azimuth, abs=0.1)
        assert (view["elevation_deg"], view["roll_deg"]) == pytest.approx((0, 0), abs=0.15)


def test_every_file_is_there_and_they_agree(gym):
    names = {file.name for file in gym.iterdir()}
    pictures = {"preview.png", "confidence.png"}
    assert names == {"probe.exr", "spectral.exr", "layers.exr", "world.exr", "report.json"} | pictures
    panorama, layers = read_probe(gym / "probe.exr"), read_layers(gym / "layers.exr")
    spectra = np.einsum("hwk,hwkl->hwl", panorama.weights, panorama.bases[panorama.basis_index])
    from_layers = layers.weights @ layers.spectra
    assert layers.weights.min() >= 0
    assert np.linalg.norm(from_layers - spectra) < 2e-2 * np.linalg.norm(
        spectra
    )  # three layers, more weights
    world = OpenEXR.File(str(gym / "world.exr"), separate_channels=True).channels()
    assert set(world) == {"R", "G", "B"}
    assert world["R"].pixels.dtype == np.float32
    report = json.loads((gym / "report.json").read_text())
    assert {"blind_fraction", "width", "seconds", "views"} <= set(report)
    assert report["blind_fraction"] < 0.01


def test_an_empty_capture_and_a_silly_width_are_refused():
    with pytest.raises(CaptureError, match="has no view"):
        finish(build_probe(Capture(views=())))
    with pytest.raises(CaptureError, match="even number"):
        finish(build_probe(Capture(views=()), width=333))
