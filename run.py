#!/usr/bin/env python3
"""Set up .venv the first time, then hand every other word to the command line.

  python3 run.py demo                         the main job on the bundled sample
  python3 run.py probe CAPTURE.toml -o out    any verb of the command line; `python3 run.py --help` lists them
  python3 run.py test [pytest arguments]      the tests
  python3 run.py build [--help]               the extension zip for Blender, in dist/
  python3 run.py setup                        only set up

Runs with any Python from 3.9 on and needs nothing else: it finds a Python 3.13 (Blender's version) for .venv,
and uv, which installs exactly what requirements.lock names. Delete .venv to start over.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent
VENV = ROOT / ".venv"
LOCK = ROOT / "requirements.lock"
STAMP = VENV / ".spectral-probe-is-set-up"
UNFINISHED = "unfinished"
BOOTSTRAP = VENV / ".uv"
WINDOWS = os.name == "nt"
BIN = VENV / ("Scripts" if WINDOWS else "bin")
EXE = ".exe" if WINDOWS else ""
PYTHON = BIN / f"python{EXE}"

OLDEST_UV = (0, 5)

# Tests of one file stay in one process, for they share what is dear to make; a process with Blender takes about 1 GB.
# One that crashes ends the tests, with the test's name: pytest-xdist would wait for ever for the rest of its file.
IN_PARALLEL = (
    *("--numprocesses", "auto", "--maxprocesses", "4"),
    *("--dist", "loadfile", "--max-worker-restart", "0"),
)

# Where distributions keep the libraries that bpy takes from the system: Debian and Ubuntu, Fedora, Arch.
PACKAGES = {
    "libX11.so.6": ("libx11-6", "libX11", "libx11"),
    "libXrender.so.1": ("libxrender1", "libXrender", "libxrender"),
    "libXfixes.so.3": ("libxfixes3", "libXfixes", "libxfixes"),
    "libXi.so.6": ("libxi6", "libXi", "libxi"),
    "libXext.so.6": ("libxext6", "libXext", "libxext"),
    "libXxf86vm.so.1": ("libxxf86vm1", "libXxf86vm", "libxxf86vm"),
    "libxkbcommon.so.0": ("libxkbcommon0", "libxkbcommon", "libxkbcommon"),
    "libxcb.so.1": ("libxcb1", "libxcb", "libxcb"),
    "libSM.so.6": ("libsm6", "libSM", "libsm"),
    "libICE.so.6": ("libice6", "libICE", "libice"),
    "libGL.so.1": ("libgl1", "libglvnd-glx", "libglvnd"),
    "libEGL.so.1": ("libegl1", "libglvnd-egl", "libglvnd"),
    "libuuid.so.1": ("libuuid1", "libuuid", "util-linux-libs"),
    "libgomp.so.1": ("libgomp1", "libgomp", "gcc-libs"),
    "libstdc++.so.6": ("libstdc++6", "libstdc++", "gcc-libs"),
    "libutil.so.1": ("libc6", "glibc", "glibc"),
}


class SetUpError(Exception):
    """The set-up cannot go on; the message says what to do."""


# ---------------------------------------------------------------- a Python 3.13


def python_commands() -> list[list[str]]:
    """Every command on this machine that may be a Python 3.13, the likeliest first."""
    found = [[sys.executable]] if sys.version_info[:2] == (3, 13) else []
    for folder in os.environ.get("PATH", "").split(os.pathsep):
        path = Path(folder or ".") / f"python3.13{EXE}"
        if path.is_file():
            found.append([str(path)])
    for root in pyenv_roots():
        folders = [folder for folder in root.glob("versions/3.13.*") if folder.is_dir()]
        for folder in sorted(folders, key=patch_number, reverse=True):
            found.append([str(folder / "python.exe" if WINDOWS else folder / "bin" / "python3.13")])
    if WINDOWS:
        found.append(["py", "-3.13"])
    return found


def pyenv_roots() -> list[Path]:
    """The folders where pyenv and pyenv-win may keep their versions."""
    named = [os.environ[name] for name in ("PYENV_ROOT", "PYENV", "PYENV_HOME") if os.environ.get(name)]
    usual = [Path.home() / ".pyenv", Path.home() / ".pyenv" / "pyenv-win"]
    return list(dict.fromkeys([Path(name) for name in named] + usual))


def patch_number(folder: Path) -> int:
    """12 for a folder named 3.13.12; -1 where the name ends otherwise (3.13t, 3.13-dev).

    >>> patch_number(Path("versions/3.13.12"))
    12
    """
    last = folder.name.split(".")[-1]
    return int(last) if last.isdigit() else -1


def is_python_313(command: list[str]) -> bool:
    """Whether the command runs and is the CPython that bpy is built for: 3.13, 64-bit, not free-threaded."""
    code = (
        "import sys, sysconfig; sys.exit(not (sys.version_info[:2] == (3, 13) and sys.maxsize > 2**32 and"
        " sys.implementation.name == 'cpython' and not sysconfig.get_config_var('Py_GIL_DISABLED')))"
    )
    try:
        return subprocess.run([*command, "-c", code], capture_output=True, timeout=60).returncode == 0
    except (OSError, subprocess.TimeoutExpired):
        return False


def find_python() -> list[str] | None:
    """The command of a Python 3.13 on this machine, or None."""
    return next((command for command in python_commands() if is_python_313(command)), None)


# ---------------------------------------------------------------- uv


def uv_is_usable(uv: Path) -> bool:
    """Whether this uv runs and is new enough for what is asked of it here."""
    try:
        answer = subprocess.run([str(uv), "--version"], capture_output=True, text=True, timeout=60)
    except (OSError, subprocess.TimeoutExpired):
        return False
    version = re.match(r"uv (\d+)\.(\d+)", answer.stdout)
    return version is not None and (int(version[1]), int(version[2])) >= OLDEST_UV


def locked(name: str) -> str:
    """The lines of requirements.lock that pin one package, with its hashes."""
    block = re.search(rf"^{re.escape(name)}==.*(?:\n[ ]+--hash.*)*", LOCK.read_text("utf-8"), re.MULTILINE)
    if block is None:
        raise SetUpError(
            f"requirements.lock does not name {name}. Get the file back: git checkout requirements.lock"
        )
    return block[0] + "\n"


def find_uv(python: list[str] | None) -> Path:
    """A usable uv: the one on PATH, else the locked version, got with pip into .venv/.uv."""
    here = [BOOTSTRAP / folder / f"uv{EXE}" for folder in ("bin", "Scripts")]
    on_path = shutil.which("uv")
    for uv in ([Path(on_path)] if on_path else []) + here:
        if uv_is_usable(uv):
            return uv
    say("Getting uv, which installs the rest")
    BOOTSTRAP.mkdir(parents=True, exist_ok=True)
    wanted = BOOTSTRAP / "uv.txt"
    wanted.write_text(locked("uv"), "utf-8")
    target = ["--target", str(BOOTSTRAP), "--upgrade", "--no-deps", "--require-hashes", "-r", str(wanted)]
    call([*pip_command(python), "install", "--quiet", "--disable-pip-version-check", *target])
    for uv in here:
        if uv_is_usable(uv):
            return uv
    raise SetUpError(
        "uv was installed but does not run here. Install uv 0.5 or later so that `uv --version` answers."
    )


def pip_command(python: list[str] | None) -> list[str]:
    """A pip, of whichever Python has one."""
    for command in ([python] if python else []) + [[sys.executable]]:
        pip = [*command, "-m", "pip"]
        if subprocess.run([*pip, "--version"], capture_output=True).returncode == 0:
            return pip
    raise SetUpError(
        "Neither pip nor uv is here to install the rest. Install pip and try again"
        " (Debian, Ubuntu: sudo apt install python3-pip; Fedora: sudo dnf install python3-pip)."
    )


# ---------------------------------------------------------------- the set-up


def fingerprint() -> str:
    """What `.venv` must have been made from to be up to date."""
    digest = hashlib.sha256(os.fsencode(ROOT))
    for name in ("requirements.lock", "pyproject.toml"):
        digest.update((ROOT / name).read_bytes())
    return digest.hexdigest()


def is_set_up() -> bool:
    """Whether `.venv` is complete and made from the files as they are now."""
    try:
        return STAMP.read_text("utf-8") == fingerprint() and PYTHON.exists()
    except OSError:
        return False


def set_up() -> None:
    """Make `.venv`; the stamp that calls it complete is written last, so an interrupted set-up goes on."""
    cut_short = STAMP.exists() and STAMP.read_text("utf-8") == UNFINISHED
    say("Setting up .venv, once: about 600 MB to download, 2 GB on disk")
    usable = is_python_313([str(PYTHON)]) and not cut_short
    if not usable:  # half written, or of a Python that is another or gone
        shutil.rmtree(VENV / ("Lib" if WINDOWS else "lib"), ignore_errors=True)
    python = [str(PYTHON)] if usable else find_python()
    uv = find_uv(python)
    if not usable:
        python = python or python_through_uv(uv)
        say(f"Python 3.13: {' '.join(python)}")
        call([uv, "venv", "--quiet", "--allow-existing", "--python", real_path(python), VENV])
    say("Installing the locked packages")
    install = ["--python", str(PYTHON)]
    STAMP.write_text(UNFINISHED, "utf-8")
    call([uv, "pip", "sync", "--require-hashes", *install, LOCK])
    call([uv, "pip", "install", "--quiet", "--no-deps", "--no-build-isolation", *install, "--editable", ROOT])
    say("Trying Blender's module")
    try_bpy()
    STAMP.write_text(fingerprint(), "utf-8")
    say("Ready")


def python_through_uv(uv: Path) -> list[str]:
    """A Python 3.13 that uv fetches, where the network allows."""
    say("No Python 3.13 on this machine: fetching one through uv")
    try:
        call([uv, "python", "install", "3.13"])
    except SetUpError:
        raise SetUpError(
            "Spectral Probe needs Python 3.13, as Blender 5.2 does; none is on this machine and none could be"
            " fetched. Install it (pyenv install 3.13, your distribution's python3.13, or an installer for"
            " Windows or macOS) and try again."
        ) from None
    return [output([uv, "python", "find", "--managed-python", "3.13"])]


def real_path(command: list[str]) -> str:
    """The interpreter behind a command such as `py -3.13` or pyenv's shim."""
    return output([*command, "-c", "import sys; print(sys.executable)"])


def try_bpy() -> None:
    """Import bpy once, so that a missing system library is told now and by its package's name."""
    answer = subprocess.run([str(PYTHON), "-c", "import bpy"], capture_output=True, text=True)
    if answer.returncode != 0:
        raise SetUpError(why_bpy_fails(answer.stderr))


def why_bpy_fails(error: str) -> str:
    """One line on why `import bpy` failed, with the package that has the missing library."""
    missing = re.search(r"(lib[\w.+-]+\.so[.\d]*): cannot open shared object file", error)
    if missing is None:
        last = (error.strip() or "it ended without a message").splitlines()[-1]
        return f"Blender's module bpy does not load here: {last}"
    library = missing[1]
    if library in PACKAGES:
        debian, fedora, arch = PACKAGES[library]
        how = f"apt install {debian} (Debian, Ubuntu), dnf install {fedora} (Fedora), pacman -S {arch} (Arch)"
    else:
        how = (
            f"its package is what apt-file search {library} (Debian, Ubuntu) or dnf provides {library} tells"
        )
    return f"Blender's module needs {library}. Install it and try again: {how}."


# ---------------------------------------------------------------- running things


def say(text: str) -> None:
    """Tell what is being done, apart from what the verbs print."""
    print(f"[spectral-probe] {text}", file=sys.stderr, flush=True)


def call(command: list[str | Path]) -> None:
    """Run one step of the set-up, its output to standard error; a failure ends the set-up."""
    environment = {"UV_HTTP_TIMEOUT": "600", **os.environ, "PIP_REQUIRE_VIRTUALENV": "false"}
    environment.setdefault("PIP_ROOT_USER_ACTION", "ignore")
    environment.pop("VIRTUAL_ENV", None)
    environment.pop("PYTHONPATH", None)
    words = [str(word) for word in command]
    try:
        status = subprocess.run(words, env=environment, stdout=2).returncode
    except OSError as error:
        raise SetUpError(f"{words[0]} does not run: {error}.") from None
    if status != 0:
        raise SetUpError(
            f"This step failed, for the reason above: {' '.join(words)}."
            " Once that is put right (is the network up?), the same command goes on from here."
        )


def output(command: list[str | Path]) -> str:
    """What a command prints."""
    answer = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if answer.returncode != 0:
        raise SetUpError(f"This step failed: {answer.stderr.strip()}")
    return answer.stdout.strip()


def hand_over(words: list[str]) -> int:
    """Run the verb in `.venv`; on POSIX this process becomes it."""
    if words[:1] == ["test"]:
        os.chdir(ROOT)  # pytest finds its settings and tests there
        command = [str(PYTHON), "-m", "pytest", *IN_PARALLEL, *words[1:]]
    elif words[:1] == ["build"]:
        command = [str(PYTHON), str(ROOT / ".ci" / "build_extension.py"), *words[1:]]
    else:
        command = [str(BIN / f"spectral-probe{EXE}"), *words]
    if not WINDOWS:
        os.execv(command[0], command)
    return subprocess.call(command)


def main(words: list[str]) -> int:
    """Set up if needed, then run the words."""
    wants_help = not words or words[0] in ("-h", "--help", "help")
    if wants_help:
        print(__doc__, flush=True)
    try:
        if not is_set_up():
            if wants_help:
                return 0
            set_up()
        if words == ["setup"]:
            return 0
        return hand_over(["--help"] if wants_help else words)
    except SetUpError as error:
        say(str(error))
        return 2
    except KeyboardInterrupt:
        say("Interrupted; the same command goes on from here")
        return 130


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
