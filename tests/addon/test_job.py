"""One job, two drivers: blocking, and modal with ESC."""

import time
from types import SimpleNamespace

import bpy
import pytest


class Log(list):
    """What happened, in order."""


@pytest.fixture
def operator(in_extension):
    """An operator of three steps, not registered: its methods are called as Blender would call them."""
    job_module, model = in_extension("operators.job"), in_extension("spectral_probe.model")

    class Steps(job_module.JobOperator):
        bl_idname, bl_label = "spectral_probe.steps", "Steps"

        def __init__(self, fails=None):
            self.log, self.reports, self.fails = Log(), [], fails

        def report(self, kind, text):
            self.reports.append((kind, text))

        def job(self, _context):
            return self.steps()

        def steps(self):
            try:
                for number in range(3):
                    self.log.append(number)
                    if self.fails and number == 1:
                        raise self.fails
                    yield model.Progress(number / 3, f"step {number}")
                return "result"
            finally:
                self.log.append("put back")

        def done(self, _context, result):
            self.log.append(result)

    return Steps


@pytest.fixture
def context(scene):
    """Stands in for the context of a window; timers and handlers are only noted."""
    manager = bpy.context.window_manager
    noted = []
    window_manager = SimpleNamespace(
        spectral_probe=manager.spectral_probe,
        property_unset=manager.property_unset,
        windows=[],
        progress_begin=lambda *_: noted.append("begin"),
        progress_update=noted.append,
        progress_end=lambda: noted.append("end"),
        event_timer_add=lambda *_, **__: noted.append("timer") or "the timer",
        event_timer_remove=lambda _: noted.append("timer removed"),
        modal_handler_add=lambda _: noted.append("handler"),
    )
    workspace = SimpleNamespace(status_text_set=lambda _text: None)
    return SimpleNamespace(
        window_manager=window_manager, workspace=workspace, window=None, noted=noted, scene=scene
    )


TIMER = SimpleNamespace(type="TIMER", value="NOTHING")
ESC = SimpleNamespace(type="ESC", value="PRESS")
CLICK = SimpleNamespace(type="LEFTMOUSE", value="PRESS")


def driven(operator, context, events):
    """The last answer of the modal driver to a list of events; stops when it is done."""
    answer = operator._begin(context)
    for event in events:
        if answer != {"RUNNING_MODAL"}:
            break
        answer = operator.modal(context, event)
        time.sleep(0.005 if operator.in_thread else 0)
    return answer


def test_blocking_runs_to_the_end(operator, context):
    steps = operator()
    assert steps.execute(context) == {"FINISHED"}
    assert steps.log == [0, 1, 2, "put back", "result"]
    assert context.noted == ["begin", 0, 1 / 3, 2 / 3, "end"]


@pytest.mark.parametrize("in_thread", [False, True])
def test_modal_gives_what_blocking_gives(operator, context, in_thread):
    steps = operator()
    steps.in_thread = in_thread
    assert driven(steps, context, [TIMER] * 100) == {"FINISHED"}
    assert steps.log == [0, 1, 2, "put back", "result"]
    assert {"timer", "handler", "timer removed", "end"} <= set(context.noted)


@pytest.mark.parametrize("in_thread", [False, True])
def test_escape_stops_at_the_next_step_and_puts_back(operator, context, in_thread):
    steps = operator()
    steps.in_thread = in_thread
    assert driven(steps, context, [TIMER, ESC, *[TIMER] * 100]) == {"CANCELLED"}
    assert steps.log[-1] == "put back"
    assert "result" not in steps.log
    assert 2 not in steps.log
    assert context.noted[-1] == "end"
    assert steps.reports == [({"INFO"}, "Steps stopped")]


def test_a_job_can_say_what_its_stop_leaves(operator, context):
    steps = operator()
    steps.after_stop = "Press again"
    assert driven(steps, context, [TIMER, ESC, *[TIMER] * 100]) == {"CANCELLED"}
    assert steps.reports == [({"INFO"}, "Steps stopped. Press again")]


def test_other_events_change_nothing_while_a_job_runs(operator, context):
    steps = operator()
    steps._begin(context)
    assert steps.modal(context, CLICK) == {"RUNNING_MODAL"}
    assert steps.modal(context, SimpleNamespace(type="MOUSEMOVE", value="NOTHING")) == {"PASS_THROUGH"}
    assert steps.log == []
    steps.cancel(context)


@pytest.mark.parametrize("in_thread", [False, True])
@pytest.mark.parametrize("driver", ["blocking", "modal"])
def test_user_errors_are_reported(operator, context, in_extension, driver, in_thread):
    steps = operator(fails=in_extension("spectral_probe.errors").CaptureError("There is no view. Add one."))
    steps.in_thread = in_thread
    answer = steps.execute(context) if driver == "blocking" else driven(steps, context, [TIMER] * 100)
    assert answer == {"CANCELLED"}
    assert steps.reports == [({"ERROR"}, "There is no view. Add one.")]
    assert steps.log == [0, 1, "put back"]
    assert context.noted[-1] == "end"


@pytest.mark.parametrize("driver", ["blocking", "modal"])
def test_defects_propagate_and_leave_nothing_behind(operator, context, driver):
    steps = operator(fails=ZeroDivisionError("a defect"))
    with pytest.raises(ZeroDivisionError):
        steps.execute(context) if driver == "blocking" else driven(steps, context, [TIMER] * 100)
    assert steps.log == [0, 1, "put back"]
    assert context.noted[-1] == "end"
    assert steps.reports == []


def test_a_closed_window_puts_back(operator, context):
    steps = operator()
    steps._begin(context)
    steps.modal(context, TIMER)
    steps.cancel(context)
    assert steps.log == [0, "put back"]
    assert context.noted[-1] == "end"


def test_panels_can_show_the_progress(operator, context):
    running = bpy.context.window_manager.spectral_probe
    steps = operator()
    steps._begin(context)
    steps.modal(context, TIMER)
    steps.modal(context, TIMER)
    assert (running.operator, running.message) == ("spectral_probe.steps", "step 1")
    assert running.fraction == pytest.approx(1 / 3)
    steps.cancel(context)
    assert bpy.context.window_manager.spectral_probe.operator == ""


def test_a_second_job_is_refused_in_one_sentence(operator, context):
    first, second = operator(), operator()
    first._begin(context)
    for answer in (second.execute(context), second.invoke(context, None)):
        assert answer == {"CANCELLED"}
    first.cancel(context)
    text = "Steps is still running. Wait until it is done, or stop it with ESC."
    assert second.reports == [({"ERROR"}, text)] * 2
    assert second.log == []


@pytest.mark.parametrize(
    ("handlers", "told"),
    [
        ("undo_pre", "undo was pressed"),
        ("redo_pre", "undo was pressed"),
        ("save_pre", "the file was saved"),
    ],
)
def test_undo_and_saving_end_a_job_on_the_scene_and_say_so(operator, context, handlers, told):
    steps = operator()
    steps._begin(context)
    steps.modal(context, TIMER)
    (handler,) = [one for one in getattr(bpy.app.handlers, handlers) if "running_job" in one.__module__]
    handler(context.scene)
    assert steps.log == [0, "put back"]
    assert steps.modal(context, CLICK) == {"CANCELLED"}
    assert steps.reports == [({"WARNING"}, f"Steps was stopped, because {told}")]
    assert context.noted[-1] == "end"


def test_switching_the_extension_off_ends_a_job(operator, context, in_extension):
    steps, module = operator(), in_extension("operators.running_job")
    steps._begin(context)
    steps.modal(context, TIMER)
    module.unregister()
    assert steps.log == [0, "put back"]
    assert module.running() is None
    for handlers in (bpy.app.handlers.undo_pre, bpy.app.handlers.redo_pre):
        assert not [one for one in handlers if "running_job" in one.__module__]
    in_extension(
        "operators.open_modals"
    ).close_all()  # Blender does not call `cancel` of an operator that is gone
    assert {"timer removed", "end"} <= set(context.noted)
    module.register()
    module.register()
    assert len([one for one in bpy.app.handlers.undo_pre if "running_job" in one.__module__]) == 1
    steps.cancel(context)


def test_the_result_is_kept_in_the_scene_the_job_was_started_in(operator, context):
    seen = []

    class Keeping(operator):
        def done(self, _context, result):
            seen.append((bpy.context.scene.name, result))

    steps = Keeping()
    started = context.scene
    other = bpy.data.scenes.new("Other")
    window = bpy.context.window_manager.windows[0]
    steps._begin(context)
    window.scene = other
    context.scene, context.temp_override = other, bpy.context.temp_override
    while steps.modal(context, TIMER) == {"RUNNING_MODAL"}:
        pass
    window.scene = started
    assert seen == [(started.name, "result")]


def test_a_scene_removed_meanwhile_is_told(operator, context):
    steps = operator()
    context.scene = bpy.data.scenes.new("Short")
    steps._begin(context)
    steps.modal(context, TIMER)
    bpy.data.scenes.remove(context.scene)
    answers = [steps.modal(context, TIMER) for _ in range(3)]
    assert answers[-1] == {"CANCELLED"}
    ((kind, text),) = steps.reports
    assert kind == {"ERROR"}
    assert text.startswith("Steps ended: its scene, or something it uses, was removed meanwhile.")


@pytest.mark.parametrize("fails", [None, "There is no view. Add one."])
def test_the_report_stays_and_can_be_copied(operator, context, in_extension, fails):
    steps = operator(fails=in_extension("spectral_probe.errors").CaptureError(fails) if fails else None)
    steps.done = lambda _context, _result: steps.tell("WARNING", "One photograph is dark.")
    driven(steps, context, [TIMER] * 5)
    report = bpy.context.window_manager.spectral_probe_reports["spectral_probe.steps"]
    assert report.finished == (fails is None)
    lines = [(line.kind, line.text) for line in report.lines]
    assert lines == [("ERROR", fails) if fails else ("WARNING", "One photograph is dark.")]
    text = in_extension("operators.job_report").report_text("spectral_probe.steps")
    assert text.splitlines() == [report.title, lines[0][1]]
    assert report.title.startswith("Steps: ended after" if fails else "Steps: done in")


def test_another_file_is_told_nothing_of_this_ones_jobs(operator, context):
    driven(operator(), context, [TIMER] * 5)
    reports = bpy.context.window_manager.spectral_probe_reports
    assert len(reports) == 1
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert len(bpy.context.window_manager.spectral_probe_reports) == 0


@pytest.fixture
def blender(in_extension, monkeypatch):
    """Stands in for Blender's render job, which needs a window: what it is asked, and how it ends."""
    module = in_extension("operators.bridge.render_job")
    state = SimpleNamespace(started=0, goes_on=False)

    def start(render):
        state.started, state.goes_on, state.render = state.started + 1, True, render
        render._started = True

    def end(told):
        state.goes_on, state.render._told = False, told

    state.end = end
    monkeypatch.setattr(module.BlenderRender, "start", start)
    monkeypatch.setattr(module.BlenderRender, "running", property(lambda _: state.goes_on))
    return state


@pytest.mark.parametrize("told", ["complete", "cancel"])
def test_the_window_waits_for_blenders_render(operator, context, in_extension, blender, told):
    module, model = in_extension("operators.bridge.render_job"), in_extension("spectral_probe.model")

    class Renders(operator):
        def steps(self):
            try:
                render = module.BlenderRender(context.scene)
                yield model.Progress(0.5, "rendering", render)
                render.result()
                self.log.append("rendered")
                return "result"
            finally:
                self.log.append("put back")

    steps = Renders()
    steps._begin(context)
    for _ in range(3):
        assert steps.modal(context, TIMER) == {"RUNNING_MODAL"}
    assert (blender.started, steps.log) == (1, [])
    blender.end(told)
    answer = steps.modal(context, TIMER)
    assert answer == ({"FINISHED"} if told == "complete" else {"CANCELLED"})
    assert steps.log == (["rendered", "put back", "result"] if told == "complete" else ["put back"])
