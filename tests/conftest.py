"""What every test may use."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def skip_unless_required() -> Callable[[str, str], None]:
    """Skip for want of something that a developer's machine need not have; where it must be there, fail."""

    def skip_or_fail(variable: str, reason: str) -> None:
        if os.environ.get(variable) == "1":
            pytest.fail(f"{reason} ({variable}=1 forbids to skip this)")
        pytest.skip(reason)

    return skip_or_fail


@pytest.fixture(scope="session")
def project_root() -> Path:
    return Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def shared_dir(project_root: Path, skip_unless_required: Callable[[str, str], None]) -> Path:
    """Reference data that is too large, or not licensed, for the repository."""
    folder = project_root.parent / "shared"
    if not (folder / "references").is_dir():
        skip_unless_required(
            "SPECTRAL_PROBE_REQUIRE_SHARED", "the reference data (../shared) is not on this machine"
        )
    return folder
