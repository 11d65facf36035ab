"""A shot as a job: what Open Job Description takes, and the same as commands."""

import shlex
from dataclasses import replace
from pathlib import Path

import pytest
import yaml
from openjd.model import create_job, decode_job_template, preprocess_job_parameters

from spectral_probe.cli_render import frame_list
from spectral_probe.errors import RenderError
from spectral_probe.farm.bundle import write_bundle
from spectral_probe.farm.commands import command_list
from spectral_probe.farm.job import FarmJob, frame_range
from spectral_probe.farm.template import asset_references, job_template, parameter_values

JOB = FarmJob(
    scene=Path("/shots/a b/scene 'one' é.blend"),
    probe=Path("/probes/gym/probe.exr"),
    frames=(-2, -1, 0, 5, 7, 9),
    shares=5,
    output=Path("/frames"),
    samples=128,
    max_de2000=0.25,
    plan=Path("/plans/plan.json"),
    swappable=(("tall window", Path("/regions/window.json")),),
    words=("--white", "D50", "--spectral"),
    files=(Path("/textures/wood.png"),),
)


def openjd_job(job, **changes):
    """The job as the standard's own model makes it from the template."""
    template = decode_job_template(template=job_template(job))
    values = {one["name"]: str(one["value"]) for one in parameter_values(job)["parameterValues"]} | changes
    here = Path("/")
    parameters = preprocess_job_parameters(
        job_template=template, job_parameter_values=values, job_template_dir=here, current_working_dir=here
    )
    return create_job(job_template=template, job_parameter_values=parameters)


def tasks_of(step):
    from openjd.model import StepParameterSpaceIterator

    return [
        {name: one.value for name, one in task.items()}
        for task in StepParameterSpaceIterator(space=step.parameterSpace)
    ]


def test_its_stages_are_frames_times_passes_frames_and_one():
    made = openjd_job(JOB)
    assert [step.name for step in made.steps] == ["Render", "Combine", "Compare"]
    render, combine, compare = made.steps
    assert tasks_of(render) == [
        {"Frame": str(frame), "Pass": str(share)} for frame in JOB.frames for share in range(1, 6)
    ]
    assert tasks_of(combine) == [{"Frame": str(frame)} for frame in JOB.frames]
    assert compare.parameterSpace is None
    assert JOB.tasks == 30 + 6 + 1
    assert [step.dependencies[0].dependsOn for step in (combine, compare)] == ["Render", "Combine"]


def test_frames_are_those_of_whoever_submits_it():
    render = openjd_job(JOB, Frames="1-3").steps[0]
    assert {task["Frame"] for task in tasks_of(render)} == {"1", "2", "3"}


def test_without_rgb_there_is_nothing_to_compare():
    assert [stage.name for stage in replace(JOB, rgb_twin=False).stages] == ["Render", "Combine"]


def test_machines_have_the_memory_and_a_gpu_where_one_is_used():
    def amounts(job):
        needs = openjd_job(job).steps[0].hostRequirements
        return {amount.name: float(amount.min) for amount in needs.amounts}

    assert amounts(replace(JOB, memory_mib=9000))["amount.worker.memory"] == 9000
    assert "amount.worker.gpu" not in amounts(JOB)
    assert amounts(replace(JOB, gpu=True))["amount.worker.gpu"] == 1


@pytest.mark.parametrize("frames", [(1,), (1, 2), (1, 3), (1, 2, 3, 10), (-3, -1, 1, 3, 4, 5, 6, 100)])
def test_ranges_of_frames_are_read_alike_by_us_and_by_the_standard(frames):
    assert frame_list(frame_range(frames)) == frames
    made = openjd_job(replace(JOB, frames=frames))
    assert [int(task["Frame"]) for task in tasks_of(made.steps[1])] == list(frames)


def test_commands_are_the_same_words_with_the_values_in_them():
    lines = [shlex.split(line) for line in command_list(JOB).splitlines() if not line.startswith("#")]
    assert len(lines) == JOB.tasks
    assert lines[0] == [
        "blender", "--background", "--command", "spectral_probe", "render-pass", str(JOB.scene),
        "--probe", "/probes/gym/probe.exr", "-o", "/frames", "--frame=-2", "--pass", "1/5", "--samples", "128",
        "--max-de", "0.25", "--plan", "/plans/plan.json", "--swappable", "tall window=/regions/window.json",
        "--white", "D50", "--spectral",
    ]  # fmt: skip
    assert lines[-1][-4:] == ["/frames", "--frames=-2-0,5-9:2", "-o", "/frames/comparison"]


def test_the_bundle_says_files_and_values(tmp_path):
    files = write_bundle(JOB, tmp_path / "job")
    read = {path.name: yaml.safe_load(path.read_text("utf-8")) for path in files}
    assert read["template.yaml"] == job_template(JOB)
    assert read["asset_references.yaml"] == asset_references(JOB)
    assert read["asset_references.yaml"]["assetReferences"]["inputs"]["filenames"] == ["/textures/wood.png"]
    assert read["openjd_values.yaml"]["Scene"] == str(JOB.scene)
    assert sorted(path.name for path in (tmp_path / "job").iterdir()) == sorted(read)


def test_another_kind_of_job_takes_the_place_of_the_first(tmp_path):
    write_bundle(JOB, tmp_path)
    write_bundle(JOB, tmp_path, "commands")
    assert [path.name for path in tmp_path.iterdir()] == ["commands.txt"]


def test_a_folder_with_something_else_is_left_alone(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(RenderError, match=r"mine\.txt"):
        write_bundle(JOB, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


@pytest.mark.parametrize(
    "changes",
    [
        {"scene": Path("/a{{Param.Blender}}.blend")},
        {"output": Path("/" + "a" * 2000)},
        {"blender": "blender\nrm"},
        {"swappable": (("}} {{", Path("/a.json")),)},
    ],
)
def test_names_that_a_template_cannot_hold_are_refused(changes, tmp_path):
    with pytest.raises(RenderError):
        write_bundle(replace(JOB, **changes), tmp_path / "job")
    assert not (tmp_path / "job").exists()
