"""Photographs dropped on a real window, and chosen in its file browser."""

import shutil


def test_photographs_come_in(scenario, project_root, tmp_path):
    gym = project_root / "sample_scenes" / "gym"
    for file in [*gym.glob("*.dng"), gym / "plate.jpg"]:
        shutil.copy(file, tmp_path)
    preset = project_root / "presets" / "spectral_probe" / "capture" / "Canon_5D_II,_Chrome_Ball.toml"
    outcome = scenario("import_photographs", tmp_path, tmp_path / "plate.jpg", preset)
    three = [3, 3, 3]
    for place in ("VIEW_3D", "IMAGE_EDITOR"):
        assert outcome.results[place] == three
        assert outcome.results[f"{place} undone"] == []
    assert outcome.results["PROPERTIES"] == three
    assert outcome.results["not chosen"] == three
    assert outcome.results["moved"] == [2, 4, 3]
    assert outcome.results["moved back"] == three
    assert outcome.results["chosen"] == three, "the plate is no view of the ball"
    assert any("9 photographs in 3 views" in line for line in outcome.reports)
    assert any("plate.jpg left out: single among brackets" in line for line in outcome.reports)
    assert outcome.results["camera"] == "Canon EOS 5D Mark II"
