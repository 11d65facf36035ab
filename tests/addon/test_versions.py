"""Files of earlier versions open with what was set in them; those of later ones lose nothing."""

import math
import tomllib
from pathlib import Path

import bpy
import pytest

OLD_FILES = Path(__file__).with_name("old_files")
VALUES = tomllib.loads((OLD_FILES / "values.toml").read_text("utf-8"))

FIRST = "122bfd3"  # the first version with panels
COMPOSITIONS = "8ff3e4c"  # several views, natural widths
LAST = "73f5516"  # the last before settings had a version

SINCE = {
    FIRST: {"scene", "camera", "probe", "render", "comparison"},
    COMPOSITIONS: {"scene", "camera", "probe", "render", "comparison"},
    LAST: {name for name, value in VALUES["scene"].items() if isinstance(value, dict)} | {"scene"},
}
"""Groups that each version had."""

LATER_SETTINGS = {
    "composition": {COMPOSITIONS, LAST},
    "max_de2000": {LAST},
    "full_samples": {LAST},
    "light": {LAST},
}


@pytest.fixture
def versions(in_extension):
    return in_extension("versions")


def opened(commit):
    bpy.ops.wm.open_mainfile(filepath=str(OLD_FILES / f"{commit}.blend"))
    return bpy.context.scene


def check(owner, values):
    for name, value in values.items():
        found = getattr(owner, name)
        if isinstance(value, float):
            assert math.isclose(found, value, rel_tol=1e-6), name
        elif isinstance(value, list):
            expected = set(value) if isinstance(found, set) else pytest.approx(value)
            assert (found if isinstance(found, set) else tuple(found)) == expected, name
        else:
            assert found == value, name


@pytest.mark.parametrize("commit", [FIRST, COMPOSITIONS, LAST])
def test_an_old_file_keeps_its_settings(commit, versions):
    scene = opened(commit)
    settings = scene.spectral_probe
    assert settings.version == versions.CURRENT
    plain = {
        name: value
        for name, value in VALUES["scene"].items()
        if not isinstance(value, dict) and commit in LATER_SETTINGS.get(name, SINCE)
    }
    check(settings, plain)
    for group in SINCE[commit] - {"scene"}:
        check(getattr(settings, group), VALUES["scene"][group])
    (view,) = settings.views
    check(
        view, {name: value for name, value in VALUES["view"].items() if name not in {"photos", "exposures_s"}}
    )
    assert [photo.path for photo in view.photos] == VALUES["view"]["photos"]
    for name in ("metal", "surface"):
        check(bpy.data.materials[name].spectral_probe, VALUES[name])


@pytest.mark.parametrize(("commit", "width"), [(FIRST, 1024), (COMPOSITIONS, 0), (LAST, 0)])
def test_a_probe_is_built_as_wide_as_its_version_did(commit, width):
    assert opened(commit).spectral_probe.probe_width == width


@pytest.mark.parametrize("commit", [COMPOSITIONS, LAST])
def test_the_world_of_an_old_file_turns_and_dims_the_passes(commit, in_extension):
    rotation, strength = in_extension("operators.bridge.world").placement(opened(commit).world)
    assert rotation == pytest.approx((0.0, 0.0, 0.75))
    assert strength == 2.5


@pytest.mark.usefixtures("scene")
def test_an_appended_scene_is_upgraded_and_those_of_the_file_are_not(versions):
    own = bpy.context.scene
    own.spectral_probe.method = "automatic"
    own.spectral_probe.property_unset("known_light")
    bpy.ops.wm.append(directory=str(OLD_FILES / f"{FIRST}.blend" / "Scene") + "/", filename="Scene")
    (appended,) = [scene for scene in bpy.data.scenes if scene != own]
    assert (appended.spectral_probe.method, appended.spectral_probe.version) == ("paper", versions.CURRENT)
    assert (own.spectral_probe.method, own.spectral_probe.version) == ("automatic", 0)


@pytest.mark.usefixtures("scene")
def test_a_linked_scene_is_upgraded():
    with bpy.data.libraries.load(str(OLD_FILES / f"{FIRST}.blend"), link=True) as (_, into):
        into.scenes = ["Scene"]
    assert into.scenes[0].spectral_probe.method == "paper"


def test_a_saved_file_is_of_this_version(settings, versions, tmp_path):
    settings.method = "automatic"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "new.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "new.blend"))
    opened_settings = bpy.context.scene.spectral_probe
    assert (opened_settings.method, opened_settings.version) == ("automatic", versions.CURRENT)


@pytest.mark.usefixtures("scene")
def test_a_file_without_settings_is_left_without(versions, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "plain.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "plain.blend"))
    assert versions.stored_settings(bpy.context.scene) is None


def test_a_later_version_loses_nothing(settings, versions, tmp_path):
    settings.version, settings.samples = versions.CURRENT + 5, 33
    versions.stored_settings(bpy.context.scene)["of_the_future"] = "kept"
    versions.stored_settings(bpy.context.scene)["method"] = 9
    for _ in range(2):
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "future.blend"))
        bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "future.blend"))
    scene = bpy.context.scene
    assert versions.is_newer(scene.spectral_probe)
    assert scene.spectral_probe.samples == 33
    stored = versions.stored_settings(scene)
    assert (stored["of_the_future"], stored["method"]) == ("kept", 9)


def test_every_version_has_its_upgrade(versions):
    assert len(versions.UPGRADES) == versions.CURRENT
