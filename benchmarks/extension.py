"""The checkout as an extension of the Blender in this process, for benchmarks that render."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
EXTENSION = "spectral_probe_extension"


def load_extension() -> None:
    """Load the checkout as a package and attach its settings to Blender's scenes and materials."""
    spec = importlib.util.spec_from_file_location(
        EXTENSION, ROOT / "__init__.py", submodule_search_locations=[str(ROOT)]
    )
    package = importlib.util.module_from_spec(spec)
    sys.modules[EXTENSION] = package
    spec.loader.exec_module(package)
    importlib.import_module(f"{EXTENSION}.properties").register()


def core(module: str) -> Any:
    """A module of the loaded extension."""
    return importlib.import_module(f"{EXTENSION}.{module}")
