"""The zip, and the scripts at the root that are no package."""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest


@pytest.fixture(scope="session")
def run_script(project_root: Path, load_script: Callable[[Path], ModuleType]) -> ModuleType:
    return load_script(project_root / "run.py")


@pytest.fixture(scope="session")
def lock(project_root) -> str:
    return (project_root / "requirements.lock").read_text("utf-8")
