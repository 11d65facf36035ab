"""What every test may use."""

from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def project_root() -> Path:
    return Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def shared_dir(project_root: Path) -> Path:
    """Reference data that is too large, or not licensed, for the repository."""
    folder = project_root.parent / "shared"
    if not (folder / "references").is_dir():
        pytest.skip("the reference data (../shared) is not on this machine")
    return folder
