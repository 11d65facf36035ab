"""Animations and view layers: every frame and every layer gets its files, and the scene its frame back."""

import bpy
import numpy as np
import pytest


@pytest.fixture
def small(scene, ball):
    """A ball that moves to the right with the frames."""
    scene.render.resolution_x = scene.render.resolution_y = 24
    scene.cycles.use_denoising = False
    ball()
    thing = bpy.context.object
    for frame, x in ((1, -1.0), (3, 1.0)):
        thing.location.x = x
        thing.keyframe_insert("location", frame=frame)
    scene.frame_set(2)
    return scene


@pytest.fixture
def planner(extension, uniform_light):
    planning = extension("operators.bridge.planning")
    return planning.Planner(uniform_light(np.linspace(0.5, 2.0, 61)), planning.PlanRequest(passes=2), 4)


def test_an_animation(small, extension, planner, tmp_path):
    frames, finish = extension("operators.bridge.frames"), extension("spectral_probe.model").finish
    read_channels = extension("spectral_probe.files.image_exr").read_channels
    small.render.film_transparent = True
    job = frames.render_frames(small, planner, tmp_path, (1, 3), rgb_twin=False)
    first = finish(job)
    assert [path.name for path in sorted(tmp_path.iterdir())] == ["frame_0001", "frame_0003"]
    assert small.frame_current == 2
    assert len(planner._plans) == 1
    coverage = [read_channels(result.image)[0]["A"] for result in first]
    assert coverage[0][:, :12].sum() > coverage[0][:, 12:].sum()
    assert coverage[1][:, :12].sum() < coverage[1][:, 12:].sum()
    again = finish(frames.render_frames(small, planner, tmp_path, (1, 3), rgb_twin=False))
    assert [result.steps_kept for result in again] == [len(result.passes) for result in again]


def test_the_frame_comes_back_when_stopped(small, extension, planner, go_on, tmp_path):
    job = extension("operators.bridge.frames").render_frames(small, planner, tmp_path, (1, 3))
    go_on(job, 3)
    assert small.frame_current == 1
    job.close()
    assert small.frame_current == 2


def test_all_view_layers_are_rendered_in_one_go(small, bridge, extension, planner, tmp_path):
    empty = small.view_layers.new("Empty/one")
    empty.layer_collection.children  # noqa: B018  (made on first sight)
    hidden = bpy.data.collections.new("Hidden")
    small.collection.children.link(hidden)
    thing = bpy.context.object
    small.collection.objects.unlink(thing)
    hidden.objects.link(thing)
    empty.layer_collection.children["Hidden"].exclude = True
    small.view_layers.new("Off").use = False
    small.render.film_transparent = True
    result = extension("spectral_probe.model").finish(
        bridge.spectral_render(small, planner.probe, None, tmp_path, samples=4, planner=planner)
    )
    read_channels = extension("spectral_probe.files.image_exr").read_channels
    assert result.layers == ("ViewLayer", "Empty/one")
    for name in ("image", "rgb"):
        assert read_channels(tmp_path / f"{name}.exr")[0]["A"].max() == 1
        assert read_channels(tmp_path / f"{name}_Empty_one.exr")[0]["A"].max() == 0
    assert not list(tmp_path.glob("*Off*"))


def test_stereoscopy_is_off_and_said(small, bridge, extension, planner, tmp_path):
    small.render.use_multiview = True
    job = bridge.spectral_render(
        small, planner.probe, None, tmp_path, samples=1, planner=planner, rgb_twin=False
    )
    assert any("Stereoscopy" in text for text in extension("spectral_probe.model").finish(job).warnings)
    assert small.render.use_multiview


def test_files_of_view_layers_never_share_a_name(extension):
    suffixes = extension("operators.bridge.assembling").layer_suffixes
    names = ["All", "../a", "a/b", "a_b", "A_B", "a_b_4", "a_b_3"]
    found = suffixes(names)
    assert found[0] == ""
    assert len({suffix.lower() for suffix in found}) == len(names)
    assert not any(set(suffix) & set("/\\") for suffix in found)
    assert suffixes([]) == [""]
