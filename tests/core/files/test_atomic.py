"""Outputs are there whole or not at all, and what killed processes left is found and removed."""

import errno
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from spectral_probe.errors import FileFormatError
from spectral_probe.files import atomic, staging
from spectral_probe.files.atomic import UNFINISHED, remove_leftovers, written_together, written_whole
from spectral_probe.files.image_exr import write_channels

KILLED = """
import os, signal, sys
from pathlib import Path
from spectral_probe.files.atomic import written_whole
with written_whole(Path(sys.argv[1])) as temporary:
    temporary.write_text("half of")
    os.kill(os.getpid(), signal.SIGKILL)
"""
WRITING = """
import sys
from pathlib import Path
from spectral_probe.files.atomic import written_whole
with written_whole(Path(sys.argv[1])) as temporary:
    print("writing", flush=True)
    sys.stdin.read()
    temporary.write_text("all of it")
"""


ROOT = Path(__file__).resolve().parents[3]


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def failing_write(path, failure):
    """Write half of a file, then fail."""
    with written_whole(path) as temporary:
        temporary.write_text("half of")
        failure(temporary)


def fails_with(number):
    """A write that the system refuses."""

    def fail(_path):
        raise OSError(number, os.strerror(number))

    return fail


def test_an_earlier_file_stays_where_the_new_one_fails(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("earlier")
    with pytest.raises(ZeroDivisionError):
        failing_write(path, lambda _path: 1 / 0)
    assert path.read_text() == "earlier"
    assert names(tmp_path) == ["a.txt"]


@pytest.mark.parametrize(
    ("number", "advice"),
    [
        (errno.ENOSPC, "Make room"),
        (errno.EDQUOT, "Make room"),
        (errno.EROFS, "Choose another place"),
        (errno.ENAMETOOLONG, "shorter name"),
        (errno.ENOENT, "Choose another place"),
    ],
)
def test_what_the_system_refuses_is_one_sentence_of_advice(tmp_path, number, advice):
    (tmp_path / "a.txt").write_text("earlier")
    with pytest.raises(FileFormatError, match=advice) as told:
        failing_write(tmp_path / "a.txt", fails_with(number))
    assert os.strerror(number) in str(told.value)
    assert "\n" not in str(told.value)
    assert (tmp_path / "a.txt").read_text() == "earlier"
    assert names(tmp_path) == ["a.txt"]


def test_the_content_is_on_the_disk_before_the_file_takes_its_place(tmp_path, monkeypatch):
    done = []
    sync, replace = os.fsync, Path.replace
    monkeypatch.setattr(os, "fsync", lambda file: (done.append("sync"), sync(file))[1])
    monkeypatch.setattr(Path, "replace", lambda self, to: (done.append("replace"), replace(self, to))[1])
    with written_whole(tmp_path / "a.txt") as temporary:
        temporary.write_text("all of it")
    assert done == ["sync", "replace", "sync"]


def test_a_disk_that_is_full_only_when_it_is_asked_to_keep_the_content(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "fsync", fails_with(errno.EDQUOT))
    with pytest.raises(FileFormatError, match=r"quota.*Make room"):
        failing_write(tmp_path / "a", str)
    assert names(tmp_path) == []


def test_a_folder_that_vanishes_meanwhile(tmp_path):
    with pytest.raises(FileFormatError, match="cannot be written"):
        failing_write(tmp_path / "out" / "a", lambda _path: shutil.rmtree(tmp_path / "out"))


def test_a_name_too_long_for_the_file_system(tmp_path):
    with pytest.raises(FileFormatError, match="shorter name"):
        failing_write(tmp_path / ("a" * 300), str)
    assert names(tmp_path) == []


@pytest.mark.skipif(not hasattr(os, "fork"), reason="limits of a process are a matter of POSIX")
def test_an_exr_that_the_disk_does_not_hold(tmp_path):
    script = (
        "import resource, signal, sys, numpy as np\n"
        "from pathlib import Path\n"
        "from spectral_probe.errors import FileFormatError\n"
        "from spectral_probe.files.image_exr import write_channels\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000))\n"
        "noise = np.random.default_rng(1).random((200, 200), np.float32)\n"
        "try:\n"
        "    write_channels(Path(sys.argv[1]), {'R': noise})\n"
        "except FileFormatError as told:\n"
        "    print(told)\n"
    )
    import numpy as np

    write_channels(tmp_path / "a.exr", {"R": np.zeros((2, 2), np.float32)})
    before = (tmp_path / "a.exr").read_bytes()
    told = subprocess.run(
        [sys.executable, "-c", script, tmp_path / "a.exr"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    assert "cannot be written" in told.stdout
    assert "Make room" in told.stdout
    assert (tmp_path / "a.exr").read_bytes() == before
    assert names(tmp_path) == ["a.exr"]


# ---------------------------------------------------------------- leftovers


def test_what_a_killed_process_left_is_removed_by_the_next(tmp_path):
    killed = subprocess.run([sys.executable, "-c", KILLED, tmp_path / "a.txt"], cwd=ROOT, check=False)
    assert killed.returncode == -signal.SIGKILL
    assert len(names(tmp_path)) == 1
    assert names(tmp_path)[0].startswith(UNFINISHED)
    with written_whole(tmp_path / "b.txt") as temporary:
        temporary.write_text("all of it")
    assert names(tmp_path) == ["b.txt"]


def test_what_a_living_process_writes_is_left_alone(tmp_path):
    with subprocess.Popen(
        [sys.executable, "-c", WRITING, tmp_path / "a.txt"],
        cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    ) as writer:  # fmt: skip
        assert writer.stdout.readline() == "writing\n"
        remove_leftovers(tmp_path)
        writer.communicate("")
    assert writer.returncode == 0
    assert (tmp_path / "a.txt").read_text() == "all of it"
    assert names(tmp_path) == ["a.txt"]


def test_what_another_machine_writes_is_left_alone_for_a_day(tmp_path):
    other = tmp_path / f"{UNFINISHED}00000000-11111111-abc"
    other.mkdir()
    (other / "half.exr").write_bytes(b"half")
    remove_leftovers(tmp_path)
    assert other.is_dir()
    long_ago = time.time() - 25 * 3600
    os.utime(other / "half.exr", (long_ago, long_ago))
    os.utime(other, (long_ago, long_ago))
    remove_leftovers(tmp_path)
    assert names(tmp_path) == []


def test_a_link_with_the_name_of_a_leftover_is_not_followed(tmp_path):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "mine.txt").write_text("mine")
    out = tmp_path / "out"
    out.mkdir()
    (out / f"{UNFINISHED}{'-'.join(staging._machine())}-x").symlink_to(elsewhere)
    remove_leftovers(out)
    assert (elsewhere / "mine.txt").read_text() == "mine"


# ---------------------------------------------------------------- several files


def write_two(folder, text, *, stale=(), failure=str):
    with written_together(folder, last="report.json", stale=stale) as staging_folder:
        for name in ("a.txt", "report.json"):
            with written_whole(staging_folder / name) as temporary:
                temporary.write_text(text)
        failure(staging_folder)


def test_none_of_several_files_is_replaced_where_one_fails(tmp_path):
    write_two(tmp_path, "earlier")
    with pytest.raises(FileFormatError, match="Make room"):
        write_two(tmp_path, "new", failure=fails_with(errno.ENOSPC))
    assert {name: (tmp_path / name).read_text() for name in names(tmp_path)} == {
        "a.txt": "earlier",
        "report.json": "earlier",
    }


@pytest.mark.parametrize("moves", range(3))
def test_a_kill_between_two_moves_is_repaired_by_the_next_run(tmp_path, monkeypatch, moves):
    write_two(tmp_path, "earlier")
    (tmp_path / "stale.txt").write_text("earlier")
    left, replace = [moves + 1], Path.replace  # the mark takes its place first

    def killed(self, to):
        if not left[0]:
            raise KeyboardInterrupt
        left[0] -= 1
        return replace(self, to)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", killed)
        if moves < 2:
            with pytest.raises(KeyboardInterrupt):
                write_two(tmp_path, "new", stale=["stale.txt"])
            assert not (tmp_path / "report.json").exists()  # says that the others do not belong together
        else:
            write_two(tmp_path, "new", stale=["stale.txt"])
    remove_leftovers(tmp_path)
    assert {name: (tmp_path / name).read_text() for name in names(tmp_path)} == {
        "a.txt": "new",
        "report.json": "new",
    }


def test_the_mark_of_a_leftover_names_no_files_elsewhere(tmp_path):
    out = tmp_path / "out"
    left = out / f"{UNFINISHED}{'-'.join(staging._machine())}-x"
    left.mkdir(parents=True)
    (tmp_path / "mine.txt").write_text("mine")
    (left / staging.MARK_NAME).write_text(json.dumps({"last": "../mine.txt", "stale": ["../../mine.txt"]}))
    remove_leftovers(out)
    assert (tmp_path / "mine.txt").read_text() == "mine"


def test_a_folder_in_the_place_of_a_file_is_found_before_anything_is_moved(tmp_path):
    (tmp_path / "report.json").mkdir()
    with pytest.raises(FileFormatError, match=r"report\.json there is a folder"):
        write_two(tmp_path, "new")
    assert names(tmp_path) == ["report.json"]


def test_leftovers_are_told_by_every_way_to_write():
    assert atomic.UNFINISHED == staging.UNFINISHED == ".writing-"
