"""The verb `farm`: a scene opened, what its frames need found out, and the job for a render farm written."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..spectral_probe.model import Job, Progress
from .command_line import open_scene, planner_of

type Numbers = dict[str, Any]


def farm(arguments: argparse.Namespace) -> Job[Numbers]:
    """Write the job that the words ask for; returns what is in it.

    Raises
    ------
    SpectralProbeError
        If the scene could not be rendered, or the job cannot be written.
    """
    from ..spectral_probe.cli_farm import farm_job
    from ..spectral_probe.farm.bundle import check_bundle_folder, write_bundle
    from ..spectral_probe.files.probe_exr import read_probe
    from ..spectral_probe.render.plan import describe
    from .bridge.farm import first_frame, scene_needs

    directory = Path(arguments.output).resolve()
    check_bundle_folder(directory)
    probe = None if arguments.world else read_probe(arguments.probe)
    yield Progress(0.0, f"Opening {arguments.scene.name}")
    scene = open_scene(arguments.scene)
    planner = planner_of(scene, probe, arguments)
    frame = min(arguments.frames)
    plan, steps = yield from first_frame(scene, planner, frame, rgb_twin=not arguments.no_rgb)
    needs = scene_needs(scene)
    job = farm_job(
        arguments,
        samples=planner.samples,
        shares=len(steps),
        memory_mib=needs.memory_mib,
        gpu=needs.gpu,
        files=needs.files,
    )
    yield Progress(0.9, "Writing the job")
    written = write_bundle(job, directory, arguments.format)
    return {
        "frames": len(job.frames),
        "passes": len(steps),
        "tasks": job.tasks,
        "plan": describe(plan),
        "files": len(needs.files),
        "render": str(job.output),
        "warnings": list(needs.warnings),
        "written": [str(path) for path in written],
    }
