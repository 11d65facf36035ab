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
    steps.after_stop = ". Press again"
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
