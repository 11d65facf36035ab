"""Runs the command line on one input after another, each in a process of its own that cannot hang or take all memory.

The libraries are imported once; each input is a fork of that process. Requests and answers are lines of JSON:
{"words": [...], "folder": "..."} -> {"status", "signal", "late", "out", "err", "peak_bytes", "cpu_s"}.
"""

from __future__ import annotations

import json
import os
import resource
import select
import signal
import sys
import time
from pathlib import Path
from typing import Any

LONGEST_S = 30.0
"""Of the processor; a process that waits for something is given as long again, for the machine may be busy."""

MOST_BYTES = 4 << 30
ROOT = Path(__file__).resolve().parents[2]


def warm() -> None:
    """Import what the verbs import, and let the library read its tables: no thread may be left running."""
    import importlib
    import pkgutil

    import cv2

    import spectral_probe
    from spectral_probe.cli import main
    from spectral_probe.spectra.camera import camera_sensitivities
    from spectral_probe.spectra.recovery import spectral_recovery

    cv2.setNumThreads(1)
    for module in pkgutil.walk_packages(spectral_probe.__path__, "spectral_probe."):
        importlib.import_module(module.name)
    spectral_recovery(camera_sensitivities("Nikon 5100 (NPL)"), ["daylight", "incandescent"], "family")
    with Path(os.devnull).open("w") as nothing:
        out, sys.stdout = sys.stdout, nothing
        for words in (["show", "SUS304"], ["show", "red"], ["list"], ["show", "A"]):
            main(["library", *words])
        sys.stdout = out


def answer(request: dict[str, Any]) -> dict[str, Any]:
    """Run one request in a fork, and say what came of it."""
    folder = Path(request["folder"])
    out, err = folder.with_name("stdout.txt"), folder.with_name("stderr.txt")
    child = os.fork()
    if child == 0:
        run(request, folder, out, err)
    ended = os.pidfd_open(child)
    late = not select.select([ended], [], [], 2 * LONGEST_S)[0]
    os.close(ended)
    if late:
        os.kill(child, signal.SIGKILL)
    _, status, used = os.wait4(child, 0)
    code = os.waitstatus_to_exitcode(status)
    return {
        "status": max(code, 0),
        "signal": -min(code, 0),
        "late": late or code == -signal.SIGXCPU,
        "out": out.read_text("utf-8", "replace")[:3000],
        "err": err.read_text("utf-8", "replace")[-3000:],
        "lines": err.read_bytes().count(b"\n"),
        "peak_bytes": used.ru_maxrss * 1024,
        "cpu_s": used.ru_utime + used.ru_stime,
    }


def run(request: dict[str, Any], folder: Path, out: Path, err: Path) -> None:
    """The child's life: its own streams, its limits, the verb, and out without cleaning up after the parent."""
    from spectral_probe.cli import main

    for stream, path in ((1, out), (2, err)):
        file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(file, stream)
        os.close(file)
    sys.stdin = Path(os.devnull).open("rb")  # noqa: SIM115  # it ends with the process
    sys.stdout, sys.stderr = (os.fdopen(number, "w", encoding="utf-8", errors="replace") for number in (1, 2))
    now = int(Path("/proc/self/statm").read_text("ascii").split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (now + MOST_BYTES,) * 2)
    resource.setrlimit(resource.RLIMIT_CPU, (int(LONGEST_S), int(LONGEST_S) + 5))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    os.chdir(folder)
    code = 70
    try:
        code = main(request["words"])
    except SystemExit as stop:
        code = stop.code if isinstance(stop.code, int) else 71
    except BaseException:  # noqa: BLE001  # it is what is looked for, and told
        import traceback

        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def serve() -> None:
    """Answer requests until there are no more."""
    sys.path.insert(0, str(ROOT))
    warm()
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    for line in sys.stdin:
        started = time.monotonic()
        answered = answer(json.loads(line)) | {"seconds": time.monotonic() - started}
        sys.stdout.write(json.dumps(answered) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    serve()
