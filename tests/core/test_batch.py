"""Many captures: which they are, what their folders are called, what is skipped, what is told of failures."""

import csv
import json
import os
import signal
import sys
import textwrap
from pathlib import Path

import cv2
import numpy as np
import pytest

from spectral_probe import batch, batch_memory, batch_processes, batch_worker
from spectral_probe.batch_captures import find_captures, named
from spectral_probe.batch_record import (
    OUTPUTS,
    RECORD_NAME,
    BatchRecord,
    digests_of,
    input_digests,
    owners,
    program_version,
    read_record,
    write_record,
)
from spectral_probe.cli import main
from spectral_probe.errors import CaptureError
from spectral_probe.files.capture import load_capture
from spectral_probe.files.lock import folder_lock

CAPTURE = """
[camera]
model = "Rec.709"
focal_px = 1500.0
[[view]]
photos = ["ball.png"]
exposures_s = [0.01]
"""


def write_capture(path, text=CAPTURE):
    """A capture of one photograph of a plain ball."""
    path.parent.mkdir(parents=True, exist_ok=True)
    image = np.full((300, 300, 3), 40, np.uint8)
    cv2.circle(image, (150, 150), 90, (200, 190, 180), -1, cv2.LINE_AA)
    cv2.imwrite(str(path.parent / "ball.png"), image)
    path.write_text(text)
    return path


@pytest.fixture
def quick(monkeypatch):
    """Processes of the batch that make no probe: each does what its capture's first line says."""
    script = textwrap.dedent(
        """
        import json, os, signal, sys, time
        from pathlib import Path
        words = json.loads(sys.stdin.readline())
        order = Path(words["capture"]).read_text().splitlines()[0]
        print("a library's own remark")
        print(json.dumps({"progress": 0.5, "message": "half"}), flush=True)
        if "killed" in order:
            os.kill(os.getpid(), signal.SIGKILL)
        if "defect" in order:
            raise ValueError("a defect")
        if "waits" in order:
            sys.stdin.read()
            sys.exit(130)
        Path(words["folder"]).mkdir(exist_ok=True)
        (Path(words["folder"]) / "probe.exr").write_text("probe")
        print(json.dumps({"done": {"width": words["width_px"], "peak_memory_mb": 900}}), flush=True)
        """
    )
    monkeypatch.setattr(batch_processes, "_command", lambda _threads: [sys.executable, "-c", script])


def run(capsys, *words):
    code = main([str(word) for word in words])
    return code, *capsys.readouterr()


# ---------------------------------------------------------------- which captures


def test_files_are_captures_by_their_content(tmp_path):
    wanted = [
        write_capture(tmp_path / "a" / "ball.toml"),
        write_capture(tmp_path / "b" / "deep" / "hall.TOML"),
        write_capture(tmp_path / "broken.toml", "[camera\n[[view]]\n"),
    ]
    (tmp_path / "pyproject.toml").write_text("[project]\nname = 'x'\n")
    (tmp_path / "other.toml").write_text("[[view]]\nname = 'no photographs'\n")
    (tmp_path / "half.toml").write_text("[project\n")
    write_capture(tmp_path / "out" / "kept.toml")
    write_capture(tmp_path / ".git" / "hidden.toml")
    (tmp_path / "again").symlink_to(tmp_path / "a")
    assert find_captures([tmp_path, wanted[0]], tmp_path / "out") == sorted(path.resolve() for path in wanted)


def test_nothing_to_find_is_said(tmp_path):
    with pytest.raises(CaptureError, match="no capture file"):
        find_captures([tmp_path], tmp_path / "out")
    with pytest.raises(CaptureError, match="There is no capture file at"):
        find_captures([tmp_path / "none.toml"], tmp_path / "out")


def test_names_collide_with_nothing(tmp_path):
    paths = [
        tmp_path / name for name in ("a/ball.toml", "b/BALL.toml", "b/summary.csv.toml", "c/a/ball.toml")
    ]
    names = [capture.name for capture in named(paths, tmp_path, {})]
    assert names == ["ball", "b_BALL", "b_summary.csv", "a_ball"]
    assert len({name.casefold() for name in names}) == len(names)


def test_a_capture_keeps_its_folder_when_others_come(tmp_path):
    out, old = tmp_path / "out", write_capture(tmp_path / "z" / "ball.toml")
    write_record(out / "ball", BatchRecord(str(old), "0", None, {}, {}))
    new = write_capture(tmp_path / "a" / "ball.toml")
    assert [one.name for one in named([new, old], out, owners(out))] == ["a_ball", "ball"]
    old.unlink()  # moved: what it had may be taken for what is there now
    assert [one.name for one in named([new], out, owners(out))] == ["ball"]


# ---------------------------------------------------------------- what is done


@pytest.fixture
def done(tmp_path):
    """A capture with a file of everything that it can name, and its finished probe."""
    text = """
    [camera]
    sensitivities = "camera.csv"
    focal_px = 1500.0
    [ball]
    material = "ball.csv"
    [light]
    spectra = ["lamp.csv"]
    [[view]]
    photos = ["ball.png"]
    exposures_s = [0.01]
    filter = "glass.csv"
    """
    for name in ("camera", "ball", "lamp", "glass"):
        (tmp_path / f"{name}.csv").write_text(name)
    capture = write_capture(tmp_path / "capture.toml", text).resolve()
    folder = tmp_path / "out" / tmp_path.name
    folder.mkdir(parents=True)
    for name in OUTPUTS:
        (folder / name).write_text(name)
    outputs = digests_of((folder / name for name in OUTPUTS), folder)
    record = BatchRecord(str(capture), program_version(), 64, input_digests(capture), outputs, {"width": 64})
    write_record(folder, record)
    return capture, folder


def status(capsys, capture, folder, *words):
    code, out, _ = run(
        capsys, "probe", capture.parent, "-o", folder.parent, "--json", *(words or ("--width", 64))
    )
    return code, json.loads(out)["table"][0]["status"]


@pytest.mark.usefixtures("quick")
def test_what_is_done_and_unchanged_is_skipped(done, capsys):
    capture, folder = done
    assert set(read_record(folder).inputs) == {
        "capture.toml", "ball.png", "camera.csv", "ball.csv", "lamp.csv", "glass.csv",
    }  # fmt: skip
    assert status(capsys, capture, folder) == (0, "skipped")
    assert status(capsys, capture, folder, "--width", 64, "--restart") == (0, "done")


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("changed", ["ball.png", "camera.csv", "ball.csv", "lamp.csv", "glass.csv"])
def test_a_changed_input_is_seen_by_its_content(done, capsys, changed):
    capture, folder = done
    path = capture.parent / changed
    before = path.stat()
    content = bytearray(path.read_bytes())
    content[-1] ^= 1
    path.write_bytes(content)
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert status(capsys, capture, folder) == (0, "done")


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("damage", ["missing", "changed", "record", "width", "program"])
def test_what_is_damaged_or_of_other_settings_is_made_again(done, capsys, damage, monkeypatch):
    capture, folder = done
    words = ("--width", 64)
    if damage == "missing":
        (folder / "world.exr").unlink()
    elif damage == "changed":
        (folder / "preview.png").write_text("preview.pnG")
    elif damage == "record":
        (folder / RECORD_NAME).write_text((folder / RECORD_NAME).read_text()[:-40])
    elif damage == "width":
        words = ("--width", 128)
    else:
        monkeypatch.setattr("spectral_probe.batch_record.program_version", lambda: "another")
    assert status(capsys, capture, folder, *words) == (0, "done")


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize(
    ("numbers", "expected"),
    [
        ({"views": "3\ud800\n4", "name": "another"}, "skipped"),
        ({"views": [3]}, "done"),
        ({"views": float("nan")}, "done"),
        ([], "done"),
    ],
)
def test_records_are_not_trusted(done, capsys, numbers, expected):
    capture, folder = done
    content = json.loads((folder / RECORD_NAME).read_text())
    (folder / RECORD_NAME).write_text(json.dumps(content | {"numbers": numbers}))
    assert status(capsys, capture, folder) == (0, expected)
    row = json.loads((folder.parent / "summary.json").read_text())["captures"][0]
    assert row["name"] == folder.name
    if expected == "skipped":
        assert row["views"] == "3  4"


# ---------------------------------------------------------------- how it ends


@pytest.mark.usefixtures("quick")
def test_failures_come_last_and_the_exit_code_tells(tmp_path, capsys):
    for name, order in (("good", ""), ("oom", "# killed"), ("worse", "# defect"), ("gone", "# photo gone")):
        write_capture(tmp_path / name / "capture.toml", f"{order}\n{CAPTURE}")
    (tmp_path / "gone" / "ball.png").unlink()
    code, out, err = run(capsys, "probe", tmp_path, "-o", tmp_path / "out", "--width", 64)
    assert code == 2
    assert "done: 1" in out
    lines = err.splitlines()
    assert len(lines) == 3
    assert lines[0].startswith("gone: capture.toml, [[view]] 1: there is no file")
    assert "oom: Its process was killed (SIGKILL), as systems do when memory runs short." in lines[1]
    assert "worse: Its process ended with a defect of this program (ValueError: a defect)." in lines[2]
    rows = list(csv.DictReader((tmp_path / "out" / "summary.csv").read_text().splitlines()))
    assert [(row["name"], row["status"]) for row in rows] == [
        ("gone", "failed"), ("good", "done"), ("oom", "failed"), ("worse", "failed"),
    ]  # fmt: skip
    assert rows[1]["width"] == "64"
    table = json.loads((tmp_path / "out" / "summary.json").read_text())["captures"]
    assert [row["name"] for row in table] == [row["name"] for row in rows]
    assert list(table[0]) == list(rows[0]) == list(batch.COLUMNS)


@pytest.mark.usefixtures("quick")
def test_a_stopped_batch_stops_its_processes_and_keeps_its_table(tmp_path):
    write_capture(tmp_path / "a" / "capture.toml", f"# waits\n{CAPTURE}")
    write_capture(tmp_path / "b" / "capture.toml", f"# waits\n{CAPTURE}")
    job = batch.probe_many([tmp_path], tmp_path / "out", 64, jobs=1)
    while "1 in work" not in next(job).message:
        pass
    job.close()
    rows = list(csv.DictReader((tmp_path / "out" / "summary.csv").read_text().splitlines()))
    assert [row["status"] for row in rows] == ["stopped", "stopped"]


@pytest.mark.usefixtures("quick")
def test_a_second_batch_into_the_same_folder_is_refused(tmp_path, capsys):
    write_capture(tmp_path / "a" / "capture.toml")
    with folder_lock(tmp_path / "out"):
        code, out, err = run(capsys, "probe", tmp_path, "-o", tmp_path / "out")
    assert (code, out) == (2, "")
    assert "is being written by another job" in err
    assert err.count("\n") == 1


@pytest.mark.parametrize("width", [63, 32, 20000])
def test_a_width_that_is_none_is_told_once(tmp_path, capsys, width):
    write_capture(tmp_path / "a" / "capture.toml")
    code, _, err = run(capsys, "probe", tmp_path, "-o", tmp_path / "out", "--width", width)
    assert (code, err.count("\n")) == (2, 1)
    assert not (tmp_path / "out").exists()


# ---------------------------------------------------------------- how many at a time


def test_memory_decides_how_many_run(tmp_path, monkeypatch):
    monkeypatch.setattr(
        batch_processes,
        "_command",
        lambda _threads: [sys.executable, "-c", "import sys; sys.stdin.read()"],
    )
    workers = batch_processes.Workers(budget_bytes=100, jobs=3, width_px=64)
    captures = named([tmp_path / f"{name}.toml" for name in "abc"], tmp_path / "out", {})
    try:
        assert workers.has_room_for(1000)  # one alone, whatever it needs
        workers.start(captures[0], 60)
        assert workers.has_room_for(40)
        assert not workers.has_room_for(41)
        workers.start(captures[1], 10)
        workers.start(captures[2], 10)
        assert not workers.has_room_for(1)  # as many as were asked for
    finally:
        workers.stop()
    assert workers.running == 0


def test_more_photographs_and_wider_panoramas_need_more_memory(tmp_path):
    one = load_capture(write_capture(tmp_path / "one.toml"))
    bracket = CAPTURE.replace('["ball.png"]', '["ball.png", "ball.png"]').replace("[0.01]", "[0.01, 0.1]")
    two = load_capture(write_capture(tmp_path / "two.toml", bracket))
    small, wide = (batch_memory.memory_needed(one, width) for width in (64, 2048))
    assert batch_memory.BASE_BYTES < small < batch_memory.memory_needed(two, 64) < wide
    assert wide - small == pytest.approx(300 * (2048**2 - 64**2) / 2)


def test_the_limit_of_a_container_counts(tmp_path):
    (tmp_path / "memory.max").write_text("1000\n")
    (tmp_path / "memory.current").write_text("400\n")
    assert batch_memory._container_free(tmp_path) == [600]
    (tmp_path / "memory.max").write_text("max\n")
    assert batch_memory._container_free(tmp_path) == []


# ---------------------------------------------------------------- real processes


@pytest.mark.long
def test_real_processes_make_what_one_alone_makes(tmp_path, capsys):
    capture = write_capture(tmp_path / "caps" / "a" / "capture.toml")
    out = tmp_path / "out"
    code, told, _ = run(capsys, "probe", tmp_path / "caps", "-o", out, "--width", 64, "--json")
    assert code == 0
    (row,) = json.loads(told)["table"]
    assert row["status"] == "done"
    assert row["peak_memory_mb"] > 50
    code, _, _ = run(capsys, "probe", capture, "-o", tmp_path / "alone", "--width", 64)
    assert code == 0
    for name in OUTPUTS:
        if name != "report.json":  # it has seconds in it
            assert (out / "a" / name).read_bytes() == (tmp_path / "alone" / name).read_bytes(), name
    assert sorted(path.name for path in out.iterdir()) == ["a", "summary.csv", "summary.json"]
    assert sorted(path.name for path in (out / "a").iterdir()) == sorted([*OUTPUTS, RECORD_NAME])
    code, told, _ = run(capsys, "probe", tmp_path / "caps", "-o", out, "--width", 64, "--json")
    assert (code, json.loads(told)["skipped"]) == (0, 1)


@pytest.mark.skipif(not hasattr(signal, "pthread_kill"), reason="signals to a thread are a matter of POSIX")
def test_a_worker_stops_when_its_batch_is_gone(monkeypatch):
    sent = []
    monkeypatch.setattr(signal, "pthread_kill", lambda _thread, number: sent.append(number))
    with Path(os.devnull).open() as nobody:
        batch_worker._stop_with(nobody)
    assert sent == [signal.SIGINT]
