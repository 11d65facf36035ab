"""Search finds the operators, and texts are in the language of Blender."""


def test_search_finds_operators_and_texts_are_translated(scenario, project_root):
    outcome = scenario("words", project_root / "sample_scenes" / "gym" / "capture.toml")
    assert outcome.results["engine"] == "CYCLES"
    assert outcome.results["regions"] == 1
    if outcome.results["german"]:
        assert outcome.results["error"].endswith("Mindestens ein Foto wählen.")
        assert any("3 Ansichten, 9 Fotos" in line for line in outcome.reports)
