"""run.py: finding a Python 3.13, knowing when there is nothing to do, and saying what is missing."""

import ast
import os
import re
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

posix_only = pytest.mark.skipif(os.name == "nt", reason="makes stand-ins for programs as shell scripts")


def stand_in(path, body="exit 0"):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{body}\n")
    path.chmod(0o755)
    return path


@pytest.fixture
def bare_machine(monkeypatch, tmp_path, run_script):
    """No Python 3.13 anywhere: an empty PATH, an empty home, and run by a 3.11."""
    for name in ("PYENV_ROOT", "PYENV", "PYENV_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setattr(run_script.sys, "version_info", (3, 11, 7, "final", 0))
    return tmp_path


def test_it_parses_on_the_oldest_python_it_promises(project_root):
    ast.parse((project_root / "run.py").read_text("utf-8"), feature_version=(3, 9))


@posix_only
@pytest.mark.usefixtures("bare_machine")
def test_there_may_be_no_python_313(run_script):
    assert run_script.find_python() is None


@posix_only
def test_a_python_on_path_is_found_and_one_that_does_not_run_is_passed_over(run_script, bare_machine):
    # pyenv's shim of a version that is not selected answers 127.
    stand_in(bare_machine / "bin" / "python3.13", "exit 127")
    assert run_script.find_python() is None
    found = stand_in(bare_machine / "bin" / "python3.13")
    assert run_script.find_python() == [str(found)]


@posix_only
@pytest.mark.parametrize("variable", [None, "PYENV_ROOT"])
def test_pyenvs_newest_313_is_found(run_script, bare_machine, monkeypatch, variable):
    root = bare_machine / (".pyenv" if variable is None else "elsewhere")
    if variable:
        monkeypatch.setenv(variable, str(root))
    for version in ("3.12.9", "3.13.2", "3.13.12", "3.14.0"):
        stand_in(root / "versions" / version / "bin" / "python3.13")
    assert run_script.find_python() == [str(root / "versions" / "3.13.12" / "bin" / "python3.13")]


def test_a_real_interpreter_is_judged_by_its_version(run_script):
    assert run_script.is_python_313([sys.executable]) == (sys.version_info[:2] == (3, 13))
    assert not run_script.is_python_313(["no-such-program"])


@posix_only
@pytest.mark.parametrize(
    ("answer", "usable"),
    [
        ("uv 0.5.0", True),
        ("uv 0.13.9 (x86_64)", True),
        ("uv 1.0.0", True),
        ("uv 0.4.30", False),
        ("else", False),
    ],
)
def test_uv_is_taken_only_if_it_is_new_enough(run_script, tmp_path, answer, usable):
    assert run_script.uv_is_usable(stand_in(tmp_path / "uv", f'echo "{answer}"')) is usable


def test_uv_itself_is_locked_with_hashes(run_script):
    lines = run_script.locked("uv").splitlines()
    assert re.match(r"uv==\d+\.\d+\.\d+ \\$", lines[0])
    assert len(lines) > 2
    assert all(line.strip().startswith("--hash=sha256:") for line in lines[1:])
    with pytest.raises(run_script.SetUpError, match="does not name no-such-package"):
        run_script.locked("no-such-package")


def test_a_missing_system_library_is_named_with_its_packages(run_script):
    error = (
        "Traceback (most recent call last):\n  ...\n"
        "ImportError: libSM.so.6: cannot open shared object file: No such file or directory\n"
    )
    assert run_script.why_bpy_fails(error) == (
        "Blender's module needs libSM.so.6. Install it and try again: apt install libsm6 (Debian, Ubuntu),"
        " dnf install libSM (Fedora), pacman -S libsm (Arch)."
    )
    assert "apt-file search libother.so.3" in run_script.why_bpy_fails(
        error.replace("libSM.so.6", "libother.so.3")
    )
    assert run_script.why_bpy_fails("x\nImportError: version GLIBC_2.28 not found").endswith(
        "GLIBC_2.28 not found"
    )


@pytest.mark.skipif(sys.platform != "linux", reason="reads what bpy needs with ldd")
def test_every_system_library_that_bpy_needs_directly_has_its_packages(run_script):
    module = Path(sysconfig.get_path("platlib")) / "bpy" / "__init__.so"
    answer = subprocess.run(["ldd", module], capture_output=True, text=True, check=True).stdout
    needed = set(
        re.findall(r"^\s*(libX\w*|libSM|libICE|libGL|libEGL|libxkb\w+)(\.so\.\d+) =>", answer, re.MULTILINE)
    )
    names = {"".join(parts) for parts in needed if "Xau" not in parts[0] and "Xdmcp" not in parts[0]}
    names -= {"libGLX.so.0", "libGLdispatch.so.0"}  # they come with libGL
    assert names
    assert names <= run_script.PACKAGES.keys()


def test_a_change_of_the_lock_calls_for_a_new_set_up(run_script, monkeypatch, tmp_path):
    for name in ("requirements.lock", "pyproject.toml"):
        (tmp_path / name).write_text("one")
    python = tmp_path / "python"
    stamp = tmp_path / "stamp"
    monkeypatch.setattr(run_script, "ROOT", tmp_path)
    monkeypatch.setattr(run_script, "PYTHON", python)
    monkeypatch.setattr(run_script, "STAMP", stamp)
    assert not run_script.is_set_up()
    stamp.write_text(run_script.fingerprint())
    assert not run_script.is_set_up(), "the interpreter is gone"
    python.touch()
    assert run_script.is_set_up()
    (tmp_path / "requirements.lock").write_text("two")
    assert not run_script.is_set_up()
    stamp.write_text(run_script.UNFINISHED)
    assert not run_script.is_set_up()


@posix_only
def test_a_failed_set_up_is_one_clear_line_and_exit_2(project_root, tmp_path):
    copy = tmp_path / "checkout"
    copy.mkdir()
    for name in ("run.py", "requirements.lock", "pyproject.toml"):
        (copy / name).write_bytes((project_root / name).read_bytes())
    stand_in(tmp_path / "bin" / "uv", 'test "$1" = --version && echo "uv 0.13.9" || exit 1')
    code = "import run; run.sys.version_info = (3, 11); run.sys.exit(run.main(['demo']))"
    answer = subprocess.run(
        [sys.executable, "-S", "-c", code],
        cwd=copy,
        env={"PATH": str(tmp_path / "bin"), "HOME": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert answer.returncode == 2
    assert "pyenv install 3.13" in answer.stderr.splitlines()[-1]
    assert "Traceback" not in answer.stderr


def test_help_needs_no_set_up(project_root, tmp_path):
    for name in ("run.py", "requirements.lock", "pyproject.toml"):
        (tmp_path / name).write_bytes((project_root / name).read_bytes())
    answer = subprocess.run(
        [sys.executable, "run.py", "--help"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert answer.returncode == 0
    assert "python3 run.py demo" in answer.stdout
    assert not (tmp_path / ".venv").exists()
