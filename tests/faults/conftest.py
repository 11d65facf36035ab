"""Faults on purpose: processes killed at random moments, inputs mutated. Outside the default suite, for the time they take.

Run the quick part, as .ci/run does, or the long one:

    .venv/bin/python -m pytest tests/faults
    .venv/bin/python -m pytest tests/faults --kills 50 --mutations 1000

Named on the command line this folder brings its options; where nobody named it, it is not collected.
"""

from __future__ import annotations

from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent

collect_ignore = ["fuzz.py"]  # a program of its own, which instruments what it imports


def pytest_addoption(parser):
    group = parser.getgroup("faults")
    group.addoption("--kills", type=int, default=2, help="how often each program is killed (default 2)")
    group.addoption(
        "--mutations", type=int, default=60, help="how many mutated inputs in all are read (default 60)"
    )


def pytest_ignore_collect(collection_path, config):
    """Leave the folder out unless its options are known, which they are where the command line names it."""
    inside = collection_path == HERE or HERE in collection_path.parents
    return True if inside and config.getoption("kills", None) is None else None


@pytest.fixture(scope="session")
def kills(request):
    """How often each program is killed."""
    return request.config.getoption("kills")


@pytest.fixture(scope="session")
def mutations(request):
    """How many mutated inputs are read."""
    return request.config.getoption("mutations")
