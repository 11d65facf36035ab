"""The zip, and the scripts at the root that are no package."""

import importlib.util
import tomllib
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest


def load_script(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"script_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def run_script(project_root) -> ModuleType:
    return load_script(project_root / "run.py")


@pytest.fixture(scope="session")
def builder(project_root) -> ModuleType:
    return load_script(project_root / ".ci" / "build_extension.py")


@pytest.fixture(scope="session")
def manifest(project_root) -> dict[str, Any]:
    return tomllib.loads((project_root / "blender_manifest.toml").read_text("utf-8"))


@pytest.fixture(scope="session")
def extension_zip(project_root, builder, manifest, skip_unless_required) -> Path:
    """The zip of this machine's platform, if it was built from the tree as it is now."""
    name = f"{manifest['id']}-{manifest['version']}-{builder.this_platform().replace('-', '_')}.zip"
    path = project_root / "dist" / name
    if not path.is_file():
        skip_unless_required("SPECTRAL_PROBE_REQUIRE_ZIP", "the zip is not built: python3 run.py build")
    product = [project_root / "blender_manifest.toml", *project_root.glob("*.py")]
    product.remove(project_root / "run.py")
    for folder in ("spectral_probe", "operators", "panels", "sample_scenes"):
        product += [file for file in (project_root / folder).rglob("*") if "__pycache__" not in file.parts]
    newest = max((file for file in product if file.is_file()), key=lambda file: file.stat().st_mtime)
    if newest.stat().st_mtime > path.stat().st_mtime:
        skip_unless_required(
            "SPECTRAL_PROBE_REQUIRE_ZIP",
            f"the zip is older than {newest.relative_to(project_root)}: python3 run.py build",
        )
    return path


@pytest.fixture(scope="session")
def lock(project_root) -> str:
    return (project_root / "requirements.lock").read_text("utf-8")
