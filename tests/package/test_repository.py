"""What must not get into the repository."""

import re
import subprocess

import pytest

LARGEST_FILE_BYTES = 5_000_000


@pytest.fixture(scope="module")
def tracked(project_root):
    answer = subprocess.run(
        ["git", "ls-files", "-z"], cwd=project_root, capture_output=True, text=True, check=False
    )
    if answer.returncode != 0:
        pytest.skip("not a git checkout")
    return [path for name in answer.stdout.split("\0") if name and (path := project_root / name).is_file()]


def test_no_file_is_above_5_megabytes(tracked):
    large = {path.name: path.stat().st_size for path in tracked if path.stat().st_size > LARGEST_FILE_BYTES}
    assert not large


def test_nothing_that_is_made_is_tracked(tracked):
    assert not [path for path in tracked if path.suffix in {".pyc", ".whl", ".zip", ".blend1"}]


def test_no_package_registry_is_named(tracked):
    # A mirror or a closed network has other hosts; pip and uv know theirs.
    hosts = re.compile(
        rb"\b(?:pypi|pythonhosted|crates|npmjs|maven)\.(?:org|io)|\bindex-url\b", re.IGNORECASE
    )
    named = [
        path.name for path in tracked if path.name != "test_repository.py" and hosts.search(path.read_bytes())
    ]
    assert not named
