"""Nothing is lost in a window: an old file, missing files, a packed probe."""


def test_an_old_file_missing_files_and_a_packed_probe(scenario, project_root, tmp_path):
    old = project_root / "tests" / "addon" / "old_files" / "122bfd3.blend"
    results = scenario("files", old, tmp_path).results
    assert results["method"] == "paper"
    assert results["after undo"] == ["paper", 1, 0]  # the upgrade is no step that undo takes back
    assert results["missing"] == 5
    assert results["grey"]
    assert results["still missing"] == ""
    assert results["found"] == ["//archive/photos/v0_0.dng", "//archive/room probe/"]
    assert results["asked first"]
    assert not results["folder made by itself"]
    assert results["unpacked"] == ["preview.png", "probe.exr", "world.exr"]
    assert {"template.yaml", "parameter_values.yaml", "asset_references.yaml"} <= set(results["farm"])
