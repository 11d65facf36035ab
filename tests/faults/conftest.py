"""Faults on purpose: processes killed at random moments, inputs mutated. Long, and longer by their options:

.venv/bin/python -m pytest tests/faults -m long
.venv/bin/python -m pytest tests/faults -m long --kills 50 --mutations 1000
"""

import pytest


@pytest.fixture(scope="session")
def kills(request):
    """How often each program is killed."""
    return request.config.getoption("kills")


@pytest.fixture(scope="session")
def mutations(request):
    """How many mutated inputs are read."""
    return request.config.getoption("mutations")
