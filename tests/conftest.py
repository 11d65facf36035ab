"""What every test may use."""

import os
from pathlib import Path

import pytest


def skip_unless_required(variable: str, reason: str) -> None:
    """Skip for want of something that a developer's machine need not have; where it must be there, fail."""
    if os.environ.get(variable) == "1":
        pytest.fail(f"{reason}, and {variable}=1 asks for it")
    pytest.skip(reason)


@pytest.fixture(scope="session")
def project_root() -> Path:
    return Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def shared_dir(project_root: Path) -> Path:
    """Reference data that is too large, or not licensed, for the repository."""
    folder = project_root.parent / "shared"
    if not (folder / "references").is_dir():
        skip_unless_required(
            "SPECTRAL_PROBE_REQUIRE_SHARED", "the reference data (../shared) is not on this machine"
        )
    return folder
