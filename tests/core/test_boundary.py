"""`spectral_probe` is plain Python: every module of it imports where there is no Blender."""

import os
import subprocess
import sys
from pathlib import Path

IMPORT_ALL = """
import importlib, pkgutil, sys, warnings

class NoBlender:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {"bpy", "mathutils", "bmesh", "gpu", "bl_ext", "addon_utils"}:
            raise ImportError(f"the core asks for {name}")

sys.meta_path.insert(0, NoBlender())
warnings.simplefilter("error")
package = importlib.import_module(sys.argv[1])
names = [module.name for module in pkgutil.walk_packages(package.__path__, package.__name__ + ".")]
for name in names:
    importlib.import_module(name)
print("\\n".join(names))
"""


def import_all(package: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", IMPORT_ALL, package],
        cwd=folder,
        env={**os.environ, "MPLBACKEND": "agg"},
        capture_output=True,
        text=True,
        check=False,
    )


def test_every_module_of_the_core_imports_without_blender(project_root):
    answer = import_all("spectral_probe", project_root)
    assert answer.returncode == 0, answer.stderr
    found = set(answer.stdout.split())
    assert {
        "spectral_probe.model",
        "spectral_probe.geometry.ball",
        "spectral_probe.spectra.recovery",
    } <= found


def test_a_module_that_asks_for_blender_is_noticed(tmp_path):
    package = tmp_path / "leaky"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "module.py").write_text("import bpy\n")
    answer = import_all("leaky", tmp_path)
    assert answer.returncode != 0
    assert "the core asks for bpy" in answer.stderr
