"""A shot of two frames, and a program that stands for Blender on a farm's machine."""

import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

collect_ignore = ["scene.py"]  # it runs in Blender

type Run = Callable[..., subprocess.CompletedProcess[str]]

_LAUNCHER = """#!{python}
# What `blender --background --command spectral_probe WORDS` does, by the bpy module.
import sys
sys.path.insert(0, {root!r})
from spectral_probe.cli import main
assert sys.argv[1:4] == ["--background", "--command", "spectral_probe"], sys.argv
sys.exit(main(sys.argv[4:]))
"""


@pytest.fixture(scope="session")
def run() -> Run:
    """Run a program without a window, with one thread, and return what it told."""

    def started(words: Sequence[str | Path], **options: object) -> subprocess.CompletedProcess[str]:
        environment = os.environ | {"OMP_NUM_THREADS": "1", "PYTHONWARNINGS": "default"}
        return subprocess.run(
            [str(word) for word in words],
            capture_output=True, text=True, check=False, timeout=900, env=environment, **options,
        )  # fmt: skip

    return started


@pytest.fixture(scope="session")
def blender(tmp_path_factory: pytest.TempPathFactory, project_root: Path) -> Path:
    """The program, by the bpy module of this environment."""
    path = tmp_path_factory.mktemp("program") / "blender"
    path.write_text(_LAUNCHER.format(python=sys.executable, root=str(project_root)))
    path.chmod(0o755)
    return path


@pytest.fixture(scope="session")
def verb(run: Run, blender: Path) -> Run:
    """Run a verb, and return what it told."""
    return lambda *words: run([blender, "--background", "--command", "spectral_probe", *words])


@pytest.fixture(scope="session")
def shot(tmp_path_factory: pytest.TempPathFactory, run: Run, verb: Run, project_root: Path) -> Path:
    """A folder with scene.blend, two frames of it, and the light of the sample, probe/probe.exr."""
    folder = tmp_path_factory.mktemp("shot")
    made = run([sys.executable, Path(__file__).with_name("scene.py"), folder / "scene.blend"])
    assert (folder / "scene.blend").is_file(), made.stderr
    capture = project_root / "sample_scenes" / "gym" / "capture.toml"
    built = verb("probe", capture, "-o", folder / "probe", "--width", "128")
    assert built.returncode == 0, built.stderr
    return folder


@pytest.fixture(scope="session")
def on_one_machine(shot: Path, verb: Run) -> Path:
    """The frames rendered one after another by one process."""
    folder = shot / "alone"
    words = ("render", shot / "scene.blend", "--probe", shot / "probe" / "probe.exr", "-o", folder)
    done = verb(*words, "--frames", "1-2")
    assert done.returncode == 0, done.stderr
    return folder
