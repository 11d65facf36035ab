"""Work that a job hands to its driver: whoever does it, and wherever, the job gives the same."""

import threading

import pytest

from spectral_probe.model import Progress, finish, part
from spectral_probe.work import Finished, Work, advance, all_worked, worked


def summing(log):
    """A job of two steps, the first as work."""
    one = yield from worked(Progress(0.2, "one"), lambda: log.append(threading.current_thread().name) or 1)
    yield Progress(0.6, "two")
    return one + 1


def test_a_driver_that_knows_nothing_of_work_gets_the_result():
    log = []
    assert finish(summing(log)) == 2
    assert log == [threading.current_thread().name]


def test_work_is_done_once_in_the_drivers_thread():
    log = []
    job = summing(log)
    step = advance(job)
    thread = threading.Thread(target=step.work.run, name="worker")
    thread.start()
    thread.join()
    assert step.work.done
    assert advance(job) == Progress(0.6, "two")
    assert advance(job) == Finished(2)
    assert log == ["worker"]


def test_a_part_of_a_job_keeps_its_work():
    step = advance(part(summing([]), 0.5, 1.0))
    assert (step.fraction, step.message) == (0.6, "one")
    assert not step.work.done


def test_an_error_is_raised_in_the_job():
    def dividing():
        try:
            yield from worked(Progress(0.0, ""), lambda: 1 / 0)
        except ZeroDivisionError:
            return "seen"

    job = dividing()
    work = advance(job).work
    work.run()
    assert work.done
    assert work.given is None
    assert advance(job) == Finished("seen")


def test_all_steps_as_work_tell_what_the_job_told():
    job = all_worked(summing([]))
    told = []
    while isinstance(step := advance(job), Progress):
        told.append((step.fraction, step.message))
        assert not step.work.done
    assert told == [(0.0, ""), (0.2, "one"), (0.6, "two")]
    assert step == Finished(2)


def test_closing_closes_the_job_within():
    log = []

    def inner():
        try:
            yield Progress(0.0, "")
            yield Progress(0.5, "")
        finally:
            log.append("put back")

    job = all_worked(inner())
    advance(job).work.run()
    advance(job)
    job.close()
    assert log == ["put back"]


def test_the_last_step_tells_that_it_was_the_last():
    job = all_worked(summing([]))
    for _ in range(2):
        advance(job)
    work = advance(job).work
    work.run()
    assert work.given == Finished(2)


def test_interrupting_is_no_result():
    work = Work(lambda: (_ for _ in ()).throw(KeyboardInterrupt))
    work.run()
    with pytest.raises(KeyboardInterrupt):
        work.result()
