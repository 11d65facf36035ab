"""Frames rendered pass by pass, in any order and by several processes, and put together without the scene: as if by one."""

import json
from dataclasses import replace

import bpy
import numpy as np
import pytest

SAMPLES = 16


@pytest.fixture
def small(scene, ball):
    """A ball."""
    scene.render.resolution_x, scene.render.resolution_y = 24, 16
    scene.cycles.use_denoising = False
    scene.camera.location.z, scene.camera.rotation_euler.x = 2.5, 1.12
    ball()
    bpy.context.object.name = "Ball"
    return scene


@pytest.fixture
def furnished(small):
    """A ball on a ground that is a shadow catcher, with its photograph's noise taken out."""
    small.cycles.use_denoising = True
    bpy.ops.mesh.primitive_plane_add(size=8.0, location=(0.0, 0.0, -1.0))
    bpy.context.object.name = "Ground"
    bpy.context.object.is_shadow_catcher = True
    return small


class Farm:
    """Tasks on one scene; each begins with what a process of its own would know."""

    def __init__(self, scene, extension, probe, directory):
        self.scene, self.directory, self.probe, self._extension = scene, directory, probe, extension
        self.share = extension("spectral_probe.render.share").Share
        self.finish = extension("spectral_probe.model").finish
        self.samples, self.request, self.given = SAMPLES, {}, self.few_wavelengths(3)

    def few_wavelengths(self, passes):
        """A plan that need not be made: the first passes of the reference, sharing the samples."""
        plan = self._extension("spectral_probe.render.plan").reference_plan()
        return replace(
            plan, wavelengths_nm=plan.wavelengths_nm[:passes], reconstruction=plan.reconstruction[:passes],
            sample_shares=np.full(passes, 1 / passes), references=tuple(range(passes)), light_sets=passes * (0,),
            consecutive=True,
        )  # fmt: skip

    def planned(self, **request):
        """Let the plan be made."""
        self.given, self.request = None, request

    def planner(self):
        planning = self._extension("operators.bridge.planning")
        request = planning.PlanRequest(**self.request)
        return planning.Planner(self.probe, request, self.samples, self.given)

    def words(self, **words):
        return self._extension("operators.bridge.beginning").FrameWords(**words)

    def job(self, which, **words):
        task = self._extension("operators.bridge.pass_task")
        which = self.share(*which) if isinstance(which, tuple) else which
        return task.render_passes(self.scene, self.planner(), self.directory, which, self.words(**words))

    def task(self, which, **words):
        return self.finish(self.job(which, **words))

    def combine(self):
        return self.finish(self._extension("operators.bridge.combining").combine(self.directory))

    def render(self, directory, **words):
        cycles = self._extension("operators.bridge.cycles")
        planner = self.planner()
        return self.finish(
            cycles.spectral_render(
                self.scene, self.probe, None, directory, samples=self.samples, planner=planner, **words
            )
        )


@pytest.fixture
def farm(small, extension, uniform_light, tmp_path):
    return Farm(small, extension, uniform_light(np.linspace(0.5, 2.0, 61)), tmp_path / "apart")


@pytest.fixture
def same(extension):
    """Compare two folders of one frame: every channel of every EXR, the plans, and the reports but for their times."""
    read = extension("spectral_probe.files.image_exr").read_channels

    def check(one, other):
        names = sorted(path.relative_to(one) for path in one.rglob("*") if path.is_file())
        assert names == sorted(path.relative_to(other) for path in other.rglob("*") if path.is_file())
        for name in names:
            if name.suffix == ".exr":
                (first, _), (second, _) = read(one / name), read(other / name)
                assert first.keys() == second.keys(), name
                for channel in first:
                    np.testing.assert_array_equal(first[channel], second[channel], f"{name} {channel}")
            elif name.name in ("plan.json", "backplate.json"):
                assert (one / name).read_bytes() == (other / name).read_bytes()
            elif name.name == "report.json":
                first, second = (json.loads((folder / name).read_text()) for folder in (one, other))
                for report in (first, second):
                    del report["seconds"], report["steps_kept"]
                    if report["without"]:
                        del report["without"]["seconds"], report["without"]["steps_kept"]
                assert first == second

    return check


@pytest.fixture
def unchanged(small, extension):
    """Whether the scene is what it was when this is first asked."""
    fingerprint = extension("operators.bridge.fingerprint").scene_fingerprint
    before = []

    def check():
        before.append(fingerprint(small))
        assert before[-1] == before[0]

    return check


@pytest.mark.long
@pytest.mark.usefixtures("furnished")
def test_all_shares_in_any_order_are_the_frame(farm, same, unchanged, tmp_path):
    """A plan of ratios, the part without the objects, twins, denoised; each share is exactly one step."""
    farm.planned(passes=3)
    unchanged()
    whole = farm.render(tmp_path / "whole")
    unchanged()
    done = [farm.task((number, 10)) for number in (5, 10, 3, 1, 2, 4, 9, 8, 7, 6)]
    unchanged()
    assert {task.count for task in done} == {10}
    assert [len(task.rendered) for task in done] == 10 * [1]
    names = [*(path.stem for path in whole.passes), "rgb"]
    assert {name for task in done for name in task.rendered} == {*names, *(f"without/{n}" for n in names)}
    together = farm.combine()
    assert together.steps_kept == len(together.passes)
    same(farm.directory, tmp_path / "whole")


@pytest.mark.parametrize("kind", ["wavelengths", pytest.param("layers of a region", marks=pytest.mark.long)])
def test_larger_shares_and_smaller_ones(farm, same, unchanged, tmp_path, kind):
    if kind == "layers of a region":
        region = np.zeros((8, 16), bool)
        region[:4] = True
        farm.planned(swappable={"ceiling": region})
    unchanged()
    whole = farm.render(tmp_path / "whole")
    assert len(whole.passes) > 2
    first, second, beyond = farm.task((2, 2)), farm.task((1, 2)), farm.task((40, 40))
    assert (first.asked[-1], beyond.asked) == ("rgb", ())
    assert len(first.rendered) + len(second.rendered) == first.count == beyond.count == len(whole.passes) + 1
    again = farm.task((1, 1))
    assert (len(again.asked), again.rendered) == (first.count, ())
    unchanged()
    farm.combine()
    same(farm.directory, tmp_path / "whole")


class TestInterrupted:
    def test_a_stopped_step_is_done_again(self, farm, unchanged):
        unchanged()
        job = farm.job("pass_01")
        while not next(job).message.startswith("Pass 2"):
            pass
        job.close()
        unchanged()
        assert not list((farm.directory / "passes").glob("*.exr"))
        assert farm.task("pass_01").rendered == ("pass_01",)

    @pytest.mark.parametrize(
        "damage",
        ["flipped", "manifest mistyped",
         *(pytest.param(name, marks=pytest.mark.long) for name in ("cut", "manifest gone", "of another plan"))],
    )  # fmt: skip
    def test_a_damaged_step_is_named_and_done_again(self, farm, extension, damage):
        words = {"rgb_twin": False, "words": ("--probe", "my probe.exr")}
        done = farm.task((1, 1), **words)
        passes = farm.directory / "passes"
        image, manifest = passes / "pass_01.exr", passes / "pass_01.json"
        content = bytearray(image.read_bytes())
        if damage == "flipped":
            content[len(content) // 2] ^= 1
            image.write_bytes(content)
        elif damage == "cut":
            image.write_bytes(content[:-50])
        elif damage == "manifest gone":
            manifest.unlink()
        else:
            changed = {"plan": "other"} if damage == "of another plan" else {"bytes": True}
            manifest.write_text(json.dumps({**json.loads(manifest.read_text()), **changed}))
        with pytest.raises(extension("spectral_probe.errors").RenderError) as told:
            farm.combine()
        assert f"1 of {done.count} passes is missing or damaged in {farm.directory}: pass_01." in str(
            told.value
        )
        assert "Render it: spectral-probe render Scene --probe 'my probe.exr' -o " in str(told.value)
        assert "\n" not in str(told.value)
        assert not (farm.directory / "report.json").exists()
        again = farm.task((1, 1), **words)
        assert again.rendered == ("pass_01",)
        assert farm.combine().xyz.is_file()


def test_a_whole_render_goes_on_with_what_tasks_have_done(farm, same, tmp_path):
    farm.task((1, 2))
    result = farm.render(farm.directory)
    assert result.steps_kept == 2
    farm.render(tmp_path / "whole")
    same(farm.directory, tmp_path / "whole")
    assert farm.task((1, 1)).rendered == ()


class TestOtherwiseBegun:
    @pytest.fixture(autouse=True)
    def begun(self, farm):
        farm.task("pass_00", rgb_twin=False)

    @pytest.mark.parametrize(
        ("change", "message"),
        [("scene", "its scene changed"), ("samples", "its samples changed"), ("light", "its light changed"),
         ("plan", "its plan changed"), ("outputs", "its outputs changed")],
    )  # fmt: skip
    def test_is_refused_in_one_sentence(self, farm, extension, uniform_light, unchanged, change, message):
        words = {"rgb_twin": change == "outputs"}
        if change == "scene":
            bpy.data.objects["Ball"].location.x += 0.5
            bpy.context.view_layer.update()
        elif change == "samples":
            farm.samples = 17
        elif change == "light":
            farm.probe = uniform_light(np.ones(61))
        elif change == "plan":
            farm.given = farm.few_wavelengths(2)
        unchanged()
        with pytest.raises(extension("spectral_probe.errors").RenderError, match=message) as told:
            farm.task("pass_01", **words)
        assert "\n" not in str(told.value)
        assert "--restart" in str(told.value)
        unchanged()
        passes = farm.directory / "passes"
        assert [path.name for path in passes.glob("*.exr")] == ["pass_00.exr"]

    def test_all_tasks_may_say_restart(self, farm):
        farm.samples = 17
        words = {"rgb_twin": False, "on_change": "restart"}
        first = farm.task("pass_01", **words)
        second = farm.task((1, 1), **words)
        assert first.rendered == ("pass_01",)
        assert set(second.rendered) == {*second.asked} - {"pass_01"}
        assert farm.combine().samples == 17

    def test_all_tasks_may_go_on(self, farm):
        farm.samples = 17
        done = farm.task((1, 1), rgb_twin=False, on_change="resume")
        assert "pass_00" not in done.rendered
        assert farm.combine().samples == SAMPLES

    def test_a_finished_frame_of_something_else_is_replaced(self, farm):
        farm.task((1, 1), rgb_twin=False)
        farm.combine()
        farm.samples = 17
        assert farm.task("pass_00", rgb_twin=False).rendered == ("pass_00",)
        assert not (farm.directory / "report.json").exists()

    def test_a_finished_frame_gets_other_outputs_without_rendering_again(self, farm, extension):
        farm.task((1, 1), rgb_twin=False)
        farm.combine()
        outputs = extension("spectral_probe.render.outputs").output_settings(spectral=True)
        done = farm.task((1, 1), rgb_twin=True, outputs=outputs)
        assert done.rendered == ("rgb",)
        result = farm.combine()
        assert result.rgb.is_file()
        assert result.xyz.with_name("spectral.exr").is_file()

    def test_names_that_there_are_not(self, farm, extension):
        with pytest.raises(
            extension("spectral_probe.errors").RenderError, match=r'no pass "pass_99". It has pass_00, '
        ):
            farm.task("pass_99", rgb_twin=False)

    def test_nothing_is_put_together_of_what_was_not_begun(self, farm, extension):
        (farm.directory / "passes" / "index.json").write_text('{"format": "spectral-probe-passes-2"}')
        with pytest.raises(extension("spectral_probe.errors").RenderError, match="There is no frame in"):
            farm.combine()


def test_a_warning_of_any_task_is_in_the_report(farm, small):
    small.render.use_multiview = True
    tree = bpy.data.materials["Material"].node_tree
    film = tree.nodes.new("ShaderNodeBsdfPrincipled")
    film.inputs["Thin Film Thickness"].default_value = 300.0
    tree.links.new(
        film.outputs[0], next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL").inputs["Surface"]
    )
    done = farm.task((1, 1), rgb_twin=False)
    told = json.loads((farm.combine().xyz.parent / "report.json").read_text())["warnings"]
    assert told == list(done.warnings)
    assert any("Stereoscopy" in text for text in told)
    assert any("thin film" in text.lower() for text in told)


def test_a_step_of_a_frame_begun_anew_meanwhile_does_not_count(farm, extension):
    """The process that loses says so, and nothing of it is taken for the other's."""
    job = farm.job("pass_00", rgb_twin=False)
    while not next(job).message.startswith("Pass 1"):
        pass
    index = farm.directory / "passes" / "index.json"
    content = json.loads(index.read_text())
    index.write_text(json.dumps({**content, "fingerprint": {**content["fingerprint"], "samples": "17"}}))
    with pytest.raises(extension("spectral_probe.errors").RenderError, match="begun anew by another process"):
        farm.finish(job)
    farm.samples = 17
    assert farm.task("pass_00", rgb_twin=False).rendered == ("pass_00",)


@pytest.mark.parametrize(("name", "of"), [("spectral_probe", ""), ("pass_00", "passes")])
def test_what_another_process_does_is_waited_for(farm, extension, name, of):
    """It begins the frame, or renders the same step."""
    locks = extension("spectral_probe.files.lock")
    job, told = farm.job("pass_00", rgb_twin=False), []
    with locks.folder_lock(farm.directory / of, name=name):
        while len(told) < 2:
            told += [text for text in [next(job).message] if "waiting for another process" in text]
    assert farm.finish(job).rendered == ("pass_00",)
