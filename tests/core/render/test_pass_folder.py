"""Steps of a plan, and the folder that remembers which are finished."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from spectral_probe.composite.backplate_file import backplate_table
from spectral_probe.composite_model import Backplate
from spectral_probe.errors import FileFormatError, RenderError
from spectral_probe.files.image_exr import write_channels
from spectral_probe.model import Camera
from spectral_probe.render.frame_record import record_table
from spectral_probe.render.outputs import output_settings
from spectral_probe.render.pass_folder import (
    INDEX_NAME,
    PassFolder,
    open_pass_folder,
    pass_samples,
    read_pass,
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
def folder(tmp_path, frame_record):
    """Two finished steps."""
    fingerprint = {"scene": "a", "light": "b"}
    folder = PassFolder(tmp_path / "passes", fingerprint, ("Layer.1", "é"), "plan", frame_record())
    folder.write_index()
    for number, name in enumerate(("pass_00", "pass_01")):
        channels = {f"0.{WORLD}.{c}": np.full((4, 4), number + 1.0, np.float32) for c in "RGBA"}
        write_channels(folder.path(name), channels)
        folder.note(name, 1.5, 8, "CPU", ["what was left out"])
    return folder


def test_what_was_noted_is_found_again(folder):
    again = open_pass_folder(folder.directory)
    assert record_table(again.record) == record_table(folder.record)
    assert (again.fingerprint, again.view_layers) == (folder.fingerprint, folder.view_layers)
    assert again.finished_names() == ("pass_00", "pass_01")
    assert again.holds("pass_00")
    assert not again.holds("pass_02")
    assert again.finished("pass_02") is None
    entry = again.finished("pass_00")
    assert (entry.seconds, entry.samples, entry.device) == (1.5, 8, "CPU")
    assert entry.warnings == ("what was left out",)
    assert again.changes({"scene": "a", "light": "b"}) == ()
    assert again.changes({"scene": "a", "light": "c", "samples": "9"}) == ("light", "samples")


def test_every_field_of_the_record_is_found_again(folder, frame_record):
    table = backplate_table(
        Backplate(
            Camera((50.0, 51.0), (2.0, 1.5), (4, 3), source="Blender"), np.eye(3), np.zeros(3), Path(), (4, 3),
            frame_px=(0.0, 0.0, 4, 3),
        ),
        folder.directory.parent,
    )  # fmt: skip
    record = frame_record(
        scene="Süd 1", frame=-3, blend=None, denoise=True, catchers=("Ground\n1",), without=True, rgb_twin=False,
        twin_level=None, mean_light=None, backplates=(table, None), words=("--white", "A B"), warnings=("left out",),
        outputs=output_settings(spectral=True, white="5000 K", denoise=False), files="f", light="0" * 32,
        to_rec709=np.linspace(0.1, 1.0, 9).reshape(3, 3) ** 2,
    )  # fmt: skip
    replace(folder, record=record).write_index()
    again = open_pass_folder(folder.directory).record
    assert record_table(again) == record_table(record)
    np.testing.assert_array_equal(again.to_rec709, record.to_rec709)
    assert again.outputs == record.outputs


@pytest.mark.parametrize("light", ["../../secret", "/etc/passwd", "0" * 31, "A" * 32])
def test_light_layers_lie_nowhere_else(folder, light):
    path = folder.directory / INDEX_NAME
    content = json.loads(path.read_text())
    path.write_text(json.dumps({**content, "record": {**content["record"], "light": light}}))
    assert open_pass_folder(folder.directory) is None


def _flip(path):
    content = bytearray(path.read_bytes())
    content[-9] ^= 1
    path.write_bytes(content)


def _cut(path):
    path.write_bytes(path.read_bytes()[:-1])


def _in_its_place_a_folder(path):
    path.unlink()
    path.mkdir()


@pytest.mark.parametrize(
    "damage", [_flip, _cut, lambda p: p.unlink(), lambda p: p.write_bytes(b""), _in_its_place_a_folder],
    ids=["flipped", "cut", "gone", "empty", "folder"],
)  # fmt: skip
def test_damage_is_seen(folder, damage):
    damage(folder.path("pass_01"))
    again = open_pass_folder(folder.directory)
    assert again.holds("pass_00")
    assert not again.holds("pass_01")


@pytest.mark.parametrize("changed", [{"fingerprint": {"scene": "other"}}, {"plan": "other"}])
def test_a_step_of_another_scene_or_plan_is_not_finished(folder, changed):
    other = replace(folder, **changed)
    assert not other.holds("pass_00")
    assert other.finished_names() == ()
    with pytest.raises(RenderError, match="begun anew by another process meanwhile"):
        other.note("pass_00", 1.0, 8)
    assert folder.holds("pass_00")


HOSTILE = [
    b"",
    b"{",
    b"[]",
    b"null",
    b"\xff\xfe",
    b"[" * 100_000,
    b'{"format": "spectral-probe-passes-2"}',
    b"3",
    b'"x"',
]


@pytest.mark.parametrize("content", HOSTILE)
def test_damaged_files_know_nothing(folder, content):
    folder.manifest_path("pass_01").write_bytes(content)
    assert folder.finished_names() == ("pass_00",)
    (folder.directory / INDEX_NAME).write_bytes(content)
    assert open_pass_folder(folder.directory) is None


WRONG = [None, True, -1, 10**400, 1e400, "text", [], {}, [None], {"a": []}, [[1.0] * 3] * 3, "\x1b[2J"]


def _paths(content, path=()):
    """Entries of nested JSON by the way to them; of lists the last one."""
    keys = {dict: list, list: lambda values: range(len(values))[-1:]}.get(type(content), lambda _: ())
    for key in keys(content):
        yield (*path, key)
        yield from _paths(content[key], (*path, key))


@pytest.mark.parametrize("name", [INDEX_NAME, "pass_00.json"])
def test_every_entry_may_be_of_any_kind(folder, name):
    """Nothing raises: what is of the wrong kind makes the file one that is not there."""
    path = folder.directory / name
    content = json.loads(path.read_text())
    for way in list(_paths(content)):
        for wrong in [*WRONG, "gone"]:
            changed = json.loads(json.dumps(content))
            *above, last = way
            holder = changed
            for key in above:
                holder = holder[key]
            if wrong == "gone":
                del holder[last]
            else:
                holder[last] = wrong
            path.write_text(json.dumps(changed))
            again = open_pass_folder(folder.directory)
            if again is not None:
                assert again.record.samples > 0
                again.holds("pass_00")


def test_a_number_of_the_wrong_kind_is_refused(folder):
    path = folder.directory / INDEX_NAME
    content = json.loads(path.read_text())
    for key, value in (
        ("samples", "8"),
        ("samples", 0),
        ("twin_level", None),
        ("to_rec709", [[0.0] * 3] * 3),
    ):
        path.write_text(json.dumps({**content, "record": {**content["record"], key: value}}))
        assert open_pass_folder(folder.directory) is None


def test_what_does_not_belong_to_it_is_removed(folder):
    (folder.directory / "notes.txt").write_text("mine")
    folder.clear(keep=True)
    assert open_pass_folder(folder.directory) is None
    assert folder.holds("pass_00")
    replace(folder, plan="other").clear(keep=True)
    assert [path.name for path in folder.directory.iterdir()] == ["notes.txt"]


def test_nothing_is_kept_where_all_is_to_be_rendered_anew(folder):
    folder.clear(keep=False)
    assert list(folder.directory.iterdir()) == []


@pytest.mark.parametrize(
    ("begun", "now", "result"),
    [(None, None, True), (None, False, False), (False, None, False), (False, True, True)],
)
def test_the_scene_decides_on_denoising_unless_asked(frame_record, begun, now, result):
    record = frame_record(denoise=True, outputs=output_settings(denoise=begun, white="A"))
    found = record.outputs_for(output_settings(denoise=now, spectral=True))
    assert (found.denoise, found.spectral, found.white.stated) == (result, True, "A")


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
