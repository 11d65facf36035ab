"""What every test may use."""

import importlib.util
import os
import tomllib
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    """Options of tests/faults; here, where pytest looks for options whatever tests are run."""
    group = parser.getgroup("faults")
    group.addoption("--kills", type=int, default=2, help="how often each program is killed (default 2)")
    group.addoption(
        "--mutations", type=int, default=60, help="how many mutated inputs in all are read (default 60)"
    )


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


@pytest.fixture(scope="session")
def load_script() -> Callable[[Path], ModuleType]:
    """A script that is in no package, as a module."""

    def load(path: Path) -> ModuleType:
        spec = importlib.util.spec_from_file_location(f"script_{path.stem}", path)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module

    return load


@pytest.fixture(scope="session")
def builder(project_root: Path, load_script: Callable[[Path], ModuleType]) -> ModuleType:
    """What builds the zip."""
    return load_script(project_root / ".ci" / "build_extension.py")


@pytest.fixture(scope="session")
def manifest(project_root: Path) -> dict[str, Any]:
    return tomllib.loads((project_root / "blender_manifest.toml").read_text("utf-8"))


@pytest.fixture(scope="session")
def extension_zip(
    project_root: Path,
    builder: ModuleType,
    manifest: dict[str, Any],
    skip_unless_required: Callable[[str, str], None],
) -> Path:
    """The zip of this machine's platform, if it was built from the tree as it is now."""
    name = f"{manifest['id']}-{manifest['version']}-{builder.this_platform().replace('-', '_')}.zip"
    path = project_root / "dist" / name
    if not path.is_file():
        skip_unless_required("SPECTRAL_PROBE_REQUIRE_ZIP", "the zip is not built: python3 run.py build")
    product = [project_root / "blender_manifest.toml", *project_root.glob("*.py")]
    product.remove(project_root / "run.py")
    for folder in ("spectral_probe", "operators", "panels", "sample_scenes", "assets"):
        product += [file for file in (project_root / folder).rglob("*") if "__pycache__" not in file.parts]
    newest = max((file for file in product if file.is_file()), key=lambda file: file.stat().st_mtime)
    if newest.stat().st_mtime > path.stat().st_mtime:
        skip_unless_required(
            "SPECTRAL_PROBE_REQUIRE_ZIP",
            f"the zip is older than {newest.relative_to(project_root)}: python3 run.py build",
        )
    return path
