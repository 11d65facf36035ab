"""Two jobs never write to one folder, and a killed one leaves nothing that blocks."""

import errno
import json
import os
import platform
import signal
import subprocess
import sys
import threading
from pathlib import Path

import filelock
import pytest

from spectral_probe.errors import FileFormatError
from spectral_probe.files.lock import folder_lock

ROOT = Path(__file__).resolve().parents[3]
HOLDING = """
import sys
from pathlib import Path
from spectral_probe.files.lock import folder_lock
with folder_lock(Path(sys.argv[1])):
    print("locked", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def holder(tmp_path):
    """Another process that holds the lock of tmp_path/out."""
    with subprocess.Popen(
        [sys.executable, "-c", HOLDING, tmp_path / "out"],
        cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        assert process.stdout.readline() == "locked\n"
        yield process
        process.stdin.close()


def test_a_second_process_is_told_who_writes_there(tmp_path, holder):
    with (
        pytest.raises(FileFormatError, match="is being written by another process") as told,
        folder_lock(tmp_path / "out"),
    ):
        pass
    assert f"({platform.node()}, process {holder.pid}, since 20" in str(told.value)
    assert "Wait for it, or choose another folder." in str(told.value)


@pytest.mark.usefixtures("holder")
@pytest.mark.parametrize("damage", ["", "{", "[1]", '{"host": 1, "process": Infinity, "since": 3}', "\xff"])
def test_a_damaged_note_of_the_holder_is_no_matter(tmp_path, damage):
    (tmp_path / "out" / ".spectral_probe.holder").write_text(damage, encoding="latin-1")
    with (
        pytest.raises(FileFormatError, match=r"written by another process\. Wait"),
        folder_lock(tmp_path / "out"),
    ):
        pass


def test_a_killed_process_leaves_no_lock_that_blocks(tmp_path, holder):
    holder.send_signal(signal.SIGKILL)
    holder.wait()
    with folder_lock(tmp_path / "out"):
        noted = json.loads((tmp_path / "out" / ".spectral_probe.holder").read_text())
        assert noted["process"] == os.getpid()
    assert not (tmp_path / "out").exists() or not list((tmp_path / "out").iterdir())


def test_whoever_waits_gets_it_when_it_is_free(tmp_path, holder):
    threading.Timer(0.2, holder.stdin.close).start()
    with folder_lock(tmp_path / "out", wait_s=30):
        assert (tmp_path / "out").is_dir()


def test_a_second_job_of_one_process_is_refused_too(tmp_path):
    told = []

    def second():
        try:
            with folder_lock(tmp_path):
                pass
        except FileFormatError as problem:
            told.append(str(problem))

    with folder_lock(tmp_path):
        thread = threading.Thread(target=second)
        thread.start()
        thread.join()
        second()
    assert len(told) == 2
    assert all("another job of this process" in text for text in told)


def test_locks_of_other_names_and_folders_do_not_mind_each_other(tmp_path):
    with (
        folder_lock(tmp_path),
        folder_lock(tmp_path, name="pass_00"),
        folder_lock(tmp_path, name="pass_01"),
        folder_lock(tmp_path / "within"),
    ):
        assert len(list(tmp_path.glob(".*.lock"))) == 3


def test_only_what_was_written_stays(tmp_path):
    with folder_lock(tmp_path / "a" / "b"):
        (tmp_path / "a" / "b" / "report.json").write_text("{}")
    assert [path.name for path in (tmp_path / "a" / "b").iterdir()] == ["report.json"]
    with folder_lock(tmp_path / "c" / "d"):
        pass
    assert not (tmp_path / "c").exists()
    (tmp_path / "e").mkdir()
    with folder_lock(tmp_path / "e"):
        pass
    assert (tmp_path / "e").is_dir()


@pytest.mark.parametrize("number", [errno.EROFS, errno.EACCES, errno.ENOSPC])
def test_a_folder_that_takes_no_file_is_refused_in_one_sentence(tmp_path, monkeypatch, number):
    def refused(_self):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(filelock.FileLock, "_acquire", refused)
    with pytest.raises(FileFormatError, match="cannot be written to") as told, folder_lock(tmp_path / "out"):
        pass
    assert os.strerror(number) in str(told.value)
    assert not (tmp_path / "out").exists()


def test_a_file_in_the_place_of_the_folder(tmp_path):
    (tmp_path / "out").write_text("mine")
    with pytest.raises(FileFormatError, match="is a file, not a folder"), folder_lock(tmp_path / "out"):
        pass


@pytest.mark.parametrize("problem", [OSError(errno.ENOLCK, "No locks available"), NotImplementedError()])
def test_a_share_without_locks_is_written_to_with_a_warning(tmp_path, monkeypatch, caplog, problem):
    def without(_self):
        raise problem

    monkeypatch.setattr(filelock.FileLock, "_acquire", without)
    with folder_lock(tmp_path):
        pass
    assert "without file locks" in caplog.text
