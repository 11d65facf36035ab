"""The zip in a Blender that was never started: installed, and driven from photographs to the comparison."""

import shutil

import pytest


@pytest.fixture
def gym(project_root, tmp_path):
    """The gym's photographs in a folder of the user's, where the results go too."""
    folder = tmp_path / "gym"
    folder.mkdir()
    source = project_root / "sample_scenes" / "gym"
    for file in [*source.glob("*.dng"), source / "capture.toml"]:
        shutil.copy(file, folder)
    return folder


def test_from_the_zip_to_the_comparison(clean_scenario, extension_zip, gym):
    outcome = clean_scenario("first_profile", extension_zip, gym)
    results = outcome.results
    assert results["views"] == [3, 3, 3]
    assert max(results["outline_rms_px"]) < 0.5
    assert results["blind_fraction"] < 0.05
    assert results["shading"] == "MATERIAL", "the light is seen"
    assert results["objects"] == ["Camera", "Copper Ball", "Gold Pedestal", "Silver Ball"]
    assert all(results["clicked"].values()), "the buttons are where the guide has them"
    assert results["passes"] >= 1
    assert 0 < results["mean_de2000"] < 50
    assert "photographs_to_light" in (outcome.folder / "steps.txt").read_text("utf-8")
    assert (gym / "probe" / "spectral.exr").is_file()
    assert (gym / "render" / "comparison" / "sheet.png").is_file()
