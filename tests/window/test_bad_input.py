"""What a user should not do, and does, in a real window: no traceback, one sentence, nothing left behind."""

import numpy as np
import pytest

from spectral_probe.files.image_exr import write_rgb


@pytest.fixture
def capture(tmp_path):
    """A disc with a smooth pattern in two views, its outline given: everything is done in a moment."""
    folder = tmp_path / "capture"
    folder.mkdir()
    rows, columns = np.mgrid[:120, :160] + 0.5
    inside = (np.hypot(columns - 80, rows - 60) < 50)[..., None]
    text = '[camera]\nmodel = "Rec.709"\nfocal_px = 900.5\n\n[ball]\nradius_m = 0.06\nmaterial = "ideal"\n'
    for view, azimuth_deg in enumerate((0, 120)):
        pattern = 0.5 + 0.3 * np.cos(columns / 9 + view)[..., None] * np.array([1.0, 0.6, 0.2])
        write_rgb(folder / f"view_{view}.exr", np.where(inside, pattern, 0.02).astype(np.float32))
        text += (
            f'\n[[view]]\nazimuth_deg = {azimuth_deg}\nphotos = ["view_{view}.exr"]\n'
            "exposures_s = [0.004]\noutline = [80.0, 60.0, 50.0]\nrefine = false\n"
        )
    path = folder / "capture.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_nothing_is_left_of_what_was_ended(scenario, capture, tmp_path):
    work = tmp_path / "work"
    work.mkdir()
    results = scenario("bad_input", capture, work).results
    gone = "Detect Ball ended: its scene, or something it uses, was removed meanwhile. Undo that, and start it again."
    assert results["detect+remove_scene"]["told"][-1] == gone
    assert results["detect+remove_scene"]["left"] == {"scenes": ["Other"]}
    running = "Detect Ball is still running. Wait until it is done, or stop it with ESC."
    assert results["second"] == [running, running]
    for name in ("off+detect", "off+drag_handle", "off+draw_region"):
        assert not any(results[name]["off"].values()), name
    for name in ("off+detect", "off_during_drag", "off_during_drawing"):
        assert results[name]["left"] == {}
    assert results["dragged"][0] == ["SPECTRAL_PROBE_OT_edit_outline"]
    assert results["dragged"][1][0] > 81
    assert results["after the drag"] == [80, 60, 50]
    assert results["drawn"][0] == ["SPECTRAL_PROBE_OT_draw_region"]
    assert results["after drawing"] == "0 0, 20 0, 20 20"
    assert results["quit during"] == "spectral_probe.render_spectral"
