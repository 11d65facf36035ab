"""Steps of a plan, and the folder that remembers which are finished."""

import json
from dataclasses import replace

import numpy as np
import pytest

from spectral_probe.errors import FileFormatError, RenderError
from spectral_probe.files.image_exr import write_channels
from spectral_probe.render.pass_folder import (
    INDEX_NAME,
    new_pass_folder,
    open_pass_folder,
    pass_samples,
    read_pass,
    remove_unfinished,
    render_steps,
    sequence_samples,
)
from spectral_probe.render.plan import reference_plan
from spectral_probe.render_model import WORLD


@pytest.fixture
def two_sets():
    """Set 0: a reference and two followers; set 1: a reference with a third of the samples, and one follower."""
    return replace(
        reference_plan(),
        wavelengths_nm=np.repeat([[550.0], [450.0], [610.0], [550.0], [450.0]], 3, 1),
        sample_shares=np.array([2 / 3, 1 / 16, 1 / 16, 1 / 3, 1 / 16]),
        references=(0, 0, 0, 3, 3),
        light_sets=(0, 0, 0, 1, 1),
    )


def test_every_sample_of_every_pass_is_rendered_once(two_sets):
    steps = render_steps(two_sets, 96)
    for number, count in enumerate(pass_samples(two_sets, 96)):
        covered = [
            s for step in steps if step.pass_number == number
            for s in range(step.first_sample, step.first_sample + step.samples)
        ]  # fmt: skip
        assert covered == list(range(count))


def test_order_and_names(two_sets):
    steps = render_steps(two_sets, 96)
    assert [step.name for step in steps] == [
        "pass_00_head", "pass_00_tail", "pass_01", "pass_02", "pass_03_head", "pass_03_tail", "pass_04",
    ]  # fmt: skip
    assert [step.guide for step in steps] == [True, False, True, True, True, False, True]
    assert [sequence_samples(two_sets, 96, step) for step in steps] == [64, 64, 64, 64, 32, 32, 32]


@pytest.mark.parametrize("samples", [1, 3, 5, 12, 1000])
def test_heads_have_the_samples_of_their_followers(two_sets, samples):
    steps = render_steps(two_sets, samples)
    for reference, followers in ((0, (1, 2)), (3, (4,))):
        head = next(s for s in steps if s.pass_number == reference)
        assert {s.samples for s in steps if s.pass_number in followers} == {head.samples}
        assert all(s.samples > 0 for s in steps)


def test_full_passes_are_one_step_each():
    steps = render_steps(reference_plan(), 16)
    assert [(s.name, s.first_sample, s.samples) for s in steps] == [
        (f"pass_{p:02d}", 0, 16) for p in range(21)
    ]


@pytest.fixture
def folder(tmp_path):
    """Two finished steps."""
    folder = new_pass_folder(tmp_path / "passes", {"scene": "a", "light": "b"}, ["Layer.1", "é"])
    for number, name in enumerate(("pass_00", "pass_01")):
        channels = {f"0.{WORLD}.{c}": np.full((4, 4), number + 1.0, np.float32) for c in "RGBA"}
        write_channels(folder.path(name), channels)
        folder.record(name, 1.5, 8)
    return folder


def test_what_was_recorded_is_found_again(folder):
    again = open_pass_folder(folder.directory)
    assert again == folder
    assert again.holds("pass_00")
    assert not again.holds("pass_02")
    assert again.changes({"scene": "a", "light": "b"}) == ()
    assert again.changes({"scene": "a", "light": "c", "samples": "9"}) == ("light", "samples")


def _flip(path):
    content = bytearray(path.read_bytes())
    content[-9] ^= 1
    path.write_bytes(content)


@pytest.mark.parametrize(
    "damage",
    [_flip, lambda p: p.write_bytes(p.read_bytes()[:-1]), lambda p: p.unlink(), lambda p: p.write_bytes(b"")],
    ids=["flipped", "cut", "gone", "empty"],
)
def test_damage_is_seen(folder, damage):
    damage(folder.path("pass_01"))
    again = open_pass_folder(folder.directory)
    assert again.holds("pass_00")
    assert not again.holds("pass_01")


@pytest.mark.parametrize(
    "content", ["", "{", "[]", "null", '{"format": "other"}', '{"format": "spectral-probe-passes-2"}']
)
def test_a_damaged_index_knows_nothing(folder, content):
    (folder.directory / INDEX_NAME).write_text(content)
    assert open_pass_folder(folder.directory) is None


def test_an_entry_of_the_wrong_kind_knows_nothing(folder):
    index = folder.directory / INDEX_NAME
    content = json.loads(index.read_text())
    content["finished"] = {"pass_00": 3}
    index.write_text(json.dumps(content))
    assert open_pass_folder(folder.directory) is None


def test_a_new_folder_holds_nothing_of_the_old(folder):
    fresh = new_pass_folder(folder.directory, folder.fingerprint, folder.view_layers)
    assert not fresh.holds("pass_00")
    assert list(folder.directory.iterdir()) == []
    assert open_pass_folder(folder.directory) is None


def test_groups_alpha_and_guide_of_a_layer(tmp_path):
    pixels = np.arange(16, dtype=np.float32).reshape(4, 4)
    channels = {f"{n}.{WORLD}.{c}": pixels + 100 * n + i for n in (0, 1) for i, c in enumerate("RGBA")}
    channels |= {f"1.lamps 1.{c}": pixels for c in "RGB"}
    channels |= {f"1.guide albedo.{c}": pixels for c in "RGBA"} | {
        f"1.guide normal.{c}": pixels for c in "XYZ"
    }
    channels["1.guide index.V"], channels["1.alpha.V"] = pixels + 7, pixels + 3
    write_channels(tmp_path / "pass.exr", channels)
    first, second = (read_pass(tmp_path / "pass.exr", layer) for layer in (0, 1))
    assert list(first.groups) == [WORLD]
    assert first.guide is None
    np.testing.assert_array_equal(first.groups[WORLD][..., 2], pixels + 2)
    assert sorted(second.groups) == ["lamps 1", WORLD]
    assert first.alpha is None
    np.testing.assert_array_equal(second.alpha, pixels + 3)
    assert second.guide.shape == (4, 4, 7)
    np.testing.assert_array_equal(second.guide[..., 6], pixels + 7)
    with pytest.raises(RenderError, match="no pass of view layer 3"):
        read_pass(tmp_path / "pass.exr", 2)
    with pytest.raises(FileFormatError):
        read_pass(tmp_path / "gone.exr")


def test_what_a_killed_render_was_writing_is_removed(tmp_path):
    for folder in (tmp_path, tmp_path / "passes"):
        (folder / ".writing-abc").mkdir(parents=True)
        (folder / ".writing-abc" / "half.exr").write_bytes(b"half")
        (folder / "whole.exr").write_bytes(b"whole")
    remove_unfinished(tmp_path)
    left = sorted(path.name for path in tmp_path.rglob("*"))
    assert left == ["passes", "whole.exr", "whole.exr"]
