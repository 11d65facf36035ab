"""Every format that is read, damaged: one sentence or a result; no traceback, no hang, no flood of memory, nothing half done."""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from random import Random
from typing import Any

import pytest

from tests.faults.mutations import mutations_of
from tests.faults.seeds import KINDS

pytestmark = pytest.mark.long

SEED = 20_26
WORKERS = 2
MOST_BYTES = 4 << 30
LONGEST_S = 30.0
SPECIAL = ("a folder", "a pipe", "a device", "another kind", "a link to nothing", "gone")
SPECIAL_SHARE = 0.08

_PROGRESS = re.compile(r" *\d+% .*\n")


class Worker:
    """A process that runs the command line on inputs, one after another."""

    def __init__(self) -> None:
        one_thread = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MPLBACKEND": "Agg"}
        self.process = subprocess.Popen(
            [sys.executable, str(Path(__file__).with_name("worker.py"))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=os.environ | one_thread,
        )
        assert self.process.stdout is not None
        assert self.process.stdout.readline() == "ready\n"

    def run(self, words: list[str], folder: Path) -> dict[str, Any]:
        """What came of the words, run in a folder."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(json.dumps({"words": words, "folder": str(folder)}) + "\n")
        self.process.stdin.flush()
        return dict(json.loads(self.process.stdout.readline()))

    def close(self) -> None:
        """End it."""
        self.process.communicate()


@pytest.fixture(scope="module")
def workers() -> Iterator[list[Worker]]:
    with ThreadPoolExecutor(WORKERS) as pool:
        started = list(pool.map(lambda _: Worker(), range(WORKERS)))
    yield started
    for worker in started:
        worker.close()


def state(folder: Path) -> dict[str, str]:
    """Content of all that is in a folder."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if path.is_symlink() or not path.is_file():
            found[name] = f"{path.lstat().st_mode}"
        else:
            found[name] = hashlib.blake2b(path.read_bytes(), digest_size=8).hexdigest()
    return found


def replaced(random: Random, path: Path, others: list[Path]) -> str:
    """Put something in a file's place that is no file of its kind; says what."""
    what = random.choice(SPECIAL)
    content = path.read_bytes()
    path.unlink()
    match what:
        case "a folder":
            path.mkdir()
        case "a pipe":
            os.mkfifo(path)
        case "a device":
            path.symlink_to(random.choice(["/dev/zero", "/dev/random", "/dev/null"]))
        case "another kind":
            other = random.choice(others)
            path.write_bytes(other.read_bytes())
            what = f"a {other.suffix}"
        case "a link to nothing":
            path.symlink_to("nowhere")
        case _:
            if random.random() < 0.5:
                path.write_bytes(b"\xef\xbb\xbf" + content)
                what = "a mark before it"
    return what


def complaint(found: dict[str, Any], before: dict[str, str], after: dict[str, str]) -> str | None:
    """What is wrong with how an input was taken; None where nothing is."""
    told = _PROGRESS.sub("", found["err"])
    checks = {
        "took too long": found["late"] or found["cpu_s"] > LONGEST_S,
        f"died of signal {found['signal']}": bool(found["signal"]),
        "took too much memory": found["peak_bytes"] > MOST_BYTES,
        f"ended with {found['status']}": found["status"] not in (0, 2),
        "more than one line, or none": found["status"] == 2 and told.count("\n") != 1,
        "says something though all is well": found["status"] == 0 and told != "",
        "prints numbers though it failed": found["status"] == 2 and found["out"] != "",
        "speaks Python": bool(re.search(r"Traceback|Errno|Error:|Warning:|<class|object at 0x", told)),
        "left unfinished work": any(".writing-" in name or name.endswith("~") for name in after),
        "changed what it read": any(after.get(name) != mark for name, mark in before.items() if not name.startswith("out/")),
        "spoiled an earlier output": found["status"] == 2
        and any(after.get(name) != mark for name, mark in before.items() if name.startswith("out/")),
        "wrote though it failed": found["status"] == 2 and any(
            name.startswith("out/") and name not in before and not name.rpartition("/")[2].startswith(".") for name in after),
        "wrote outside its folder": any(not name.startswith(("out/", ".")) and name not in (*before, "out") for name in after),
    }  # fmt: skip
    return next((words for words, wrong in checks.items() if wrong), None)


def mutated(random: Random, path: Path, others: list[Path]) -> str:
    """Damage a file; says how."""
    if random.random() < SPECIAL_SHARE:
        return replaced(random, path, others)
    mutation = random.choice(mutations_of(path))
    path.write_bytes(mutation(random, path.read_bytes()))
    return mutation.__name__


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A folder of sound inputs of every kind; kinds of one maker share its work."""
    made: dict[Any, Path] = {}
    folders = {}
    for name, kind in KINDS.items():
        if kind.make not in made:
            made[kind.make] = tmp_path_factory.mktemp("sound")
            kind.make(made[kind.make])
            earlier = made[kind.make] / "out"
            earlier.mkdir()
            for output in (
                "report.json",
                "probe.exr",
                "camera.json",
                "stained.exr",
                "spectrum.csv",
                "composite.json",
                "compare.json",
            ):
                (earlier / output).write_text("of an earlier run\n")
        folders[name] = made[kind.make]
    return folders


def run_one(worker: Worker, sound: dict[str, Path], name: str, number: int, scratch: Path) -> str | None:
    """One mutated input of a kind; what is wrong with how it was taken."""
    kind, random = KINDS[name], Random(f"{SEED} {name} {number}")
    folder = scratch / f"{number}" / "work"
    shutil.copytree(sound[name], folder)
    others = [
        sound[other] / KINDS[other].target for other in ("board a.png", "board a.jpg", "capture", "probe.exr")
    ]
    how = mutated(random, folder / kind.target, others)
    before = state(folder)
    found = worker.run(list(kind.words), folder)
    wrong = complaint(found, before, state(folder))
    if wrong is None:
        shutil.rmtree(folder.parent)
        return None
    return (
        f"{name} {number} ({how}): {wrong}; status {found['status']}, {found['cpu_s']:.1f} s\n{found['err']}"
    )


@pytest.mark.parametrize("name", KINDS)
def test_sound_inputs_are_taken(name, sound, workers, tmp_path):
    """Else the mutated ones would say little."""
    shutil.copytree(sound[name], tmp_path / "work")
    found = workers[0].run(list(KINDS[name].words), tmp_path / "work")
    boards = name.startswith("board")  # too few and too small to calibrate a camera with
    assert found["status"] == (2 if boards else 0), found["err"]


def test_mutated_inputs(sound, workers, mutations, tmp_path):
    """So many in all, spread over the kinds."""
    names = list(KINDS)
    jobs = [(names[number % len(names)], number) for number in range(mutations)]

    def run(at: int) -> list[str | None]:
        return [run_one(workers[at], sound, name, number, tmp_path) for name, number in jobs[at::WORKERS]]

    with ThreadPoolExecutor(WORKERS) as pool:
        complaints = [text for texts in pool.map(run, range(WORKERS)) for text in texts if text]
    assert not complaints, f"{len(complaints)} of {mutations}:\n\n" + "\n\n".join(complaints)
