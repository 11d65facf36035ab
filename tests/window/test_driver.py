"""The driver of the window tests itself: what it presses reaches Blender, and what goes wrong is noticed."""


def test_keys_search_drops_drags_and_freezes_reach_blender(scenario, project_root):
    outcome = scenario("driver", project_root / "sample_scenes" / "gym" / "capture.toml")
    assert outcome.results == {
        "selected by a key": 3,
        "modifiers found by search": 1,
        "polls": True,
        "polls again": False,
        "error": "There is no capture file at /none.toml. Check the path.",
        "views dropped": 3,
        "turned by a drag": True,
    }
    assert outcome.freezes_s["frozen"] >= 0.4
    assert any("3 views, 9 photographs" in line for line in outcome.reports)
    for name in ("search", "sidebar", "screen"):
        assert (outcome.folder / f"{name}.png").stat().st_size > 1000
