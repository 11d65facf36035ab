"""The panorama tools in a real window: mouse and keys do what they say, the viewport follows, nothing stays behind."""

from pathlib import Path

import pytest


@pytest.fixture
def gym_probe(project_root: Path, tmp_path: Path) -> Path:
    """A small probe of the simulated gym."""
    from spectral_probe.cli import main

    capture = project_root / "sample_scenes" / "gym" / "capture.toml"
    assert main(["probe", str(capture), "-o", str(tmp_path / "probe"), "--width", "256"]) == 0
    return tmp_path / "probe"


def test_point_draw_choose_and_undo_over_the_panorama(scenario, gym_probe):
    outcome = scenario("panorama", gym_probe)
    found = outcome.results
    assert not found["picks without a picture"]
    assert found["pointed at"][1] == 61
    assert found["after ESC"] == [False, True]
    assert found["taken"] == [pytest.approx(4, abs=1), pytest.approx(21, abs=1), True]
    assert found["drawn"] == ["POLYGON", 4]
    assert found["drawn after ESC"]
    assert len(found["corners after dragging"].split(",")) == 5
    assert found["corners after removing"] == 4
    assert found["undone"]
    assert found["closed on its first corner"] == ["", 4]
    assert found["edits"] == ["copper-ruby"]
    assert found["edits after undo"] == []
    assert not found["following another image"]
    assert found["tools in a new file"] == ["", False]
    for name in ("pointing", "editing", "glass", "kinds"):
        assert (outcome.folder / f"{name}.png").stat().st_size > 1000
