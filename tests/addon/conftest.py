"""Blender for the tests of the extension: its own empty user folders, and the extension through Blender's loader."""

import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import numpy as np
import pytest

MODULE = "bl_ext.user_default.spectral_probe"

# Blender reads this when bpy is imported, unless tests of another folder did so in the same process: then theirs counts.
_resources = tempfile.TemporaryDirectory(prefix="spectral_probe_blender_")
if "bpy" not in sys.modules:
    os.environ["BLENDER_USER_RESOURCES"] = _resources.name
_repository = Path(os.environ["BLENDER_USER_RESOURCES"]) / "extensions" / "user_default"
_repository.mkdir(parents=True)
(_repository / "spectral_probe").symlink_to(Path(__file__).resolve().parents[2], target_is_directory=True)

import bpy  # noqa: E402  (not before its folders are set)


def _raise(error: Exception) -> None:
    raise error


@pytest.fixture(scope="module", autouse=True)
def extension() -> Iterator[ModuleType]:
    """The extension, enabled."""
    import addon_utils  # is there once bpy is imported

    module = addon_utils.enable(MODULE, handle_error=_raise)
    assert Path(module.__file__).is_relative_to(_repository)
    yield module
    addon_utils.disable(MODULE, handle_error=_raise)


@pytest.fixture
def scene() -> Any:
    """The scene of a new file."""
    bpy.ops.wm.read_homefile(use_empty=False, use_factory_startup=True)
    return bpy.context.scene


@pytest.fixture
def settings(scene: Any) -> Any:
    return scene.spectral_probe


@pytest.fixture(scope="module")
def in_extension() -> Callable[[str], ModuleType]:
    """Import a module of the extension: not the same as the core's of that name, it is loaded twice."""
    import importlib

    return lambda name: importlib.import_module(f"{MODULE}.{name}")


@pytest.fixture
def capture_file(tmp_path: Path, in_extension: Callable[[str], ModuleType]) -> Path:
    """A capture of two views: a disc with a smooth pattern, seen with a long lens, its outline given."""
    write_rgb = in_extension("spectral_probe.files.image_exr").write_rgb
    rows, columns = np.mgrid[:120, :160] + 0.5
    inside = np.hypot(columns - 80, rows - 60) < 50
    text = '[camera]\nmodel = "Rec.709"\nfocal_px = 900.5\n\n[ball]\nradius_m = 0.06\nmaterial = "ideal"\n'
    for view, azimuth_deg in enumerate((0, 120)):
        pattern = 0.5 + 0.3 * np.cos(columns / 9 + view)[..., None] * np.array([1.0, 0.6, 0.2])
        image = np.where(inside[..., None], pattern, 0.02).astype(np.float32)
        write_rgb(tmp_path / f"view_{view}.exr", image)
        text += (
            f'\n[[view]]\nazimuth_deg = {azimuth_deg}\nphotos = ["view_{view}.exr"]\n'
            "exposures_s = [0.004]\noutline = [80.0, 60.0, 50.0]\nrefine = false\n"
        )
    path = tmp_path / "capture.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def write_small_probe(in_extension: Callable[[str], ModuleType]) -> Callable[[Path], None]:
    """Write a probe of 32 x 16 into a folder: a window, at bearing 0 and 30 degrees up, in a dim room."""

    def write(folder: Path) -> None:
        level = np.full((16, 32, 1), 0.05, np.float32)
        level[4:7, 13:19] = 1
        whole = np.ones((16, 32), bool)
        panorama = in_extension("spectral_probe.model").SpectralPanorama(
            level,
            in_extension("spectral_probe.spectra.library").daylight(6500.0)[None, None],
            np.zeros((16, 32), np.uint8),
            in_extension("spectral_probe.spectra.grid").WAVELENGTHS_NM,
            whole,
            whole.astype(np.float32),
        )
        in_extension("spectral_probe.model").finish(
            in_extension("spectral_probe.editing")._write_light(panorama, folder)
        )

    return write


class _PanelInstance:
    """What draw() is called on: the panel's class with a layout."""

    def __init__(self, panel: type, layout: Any) -> None:
        self.layout = layout
        self._panel = panel

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._panel, name)
        return value.__get__(self) if isinstance(value, FunctionType) else value  # bound as a method is


@pytest.fixture
def drawn() -> Callable[..., list[dict[str, Any]]]:
    """Draw a panel without a window and return its widgets; an empty list where its poll() says no.

    A property that does not exist raises nothing in Blender: it leaves a widget without "rna".
    """

    def draw(panel: type, **override: Any) -> list[dict[str, Any]]:
        window = bpy.context.window_manager.windows[0]
        areas = window.screen.areas
        area = next((area for area in areas if area.type == panel.bl_space_type), areas[0])
        with of_type(area, panel.bl_space_type):
            region = next(region for region in area.regions if region.type == panel.bl_region_type)
            place = {"window": window, "area": area, "region": region}
            with bpy.context.temp_override(**place, **override):
                return widgets(panel)

    def widgets(panel: type) -> list[dict[str, Any]]:
        if hasattr(panel, "poll") and not panel.poll(bpy.context):
            return []
        menu = bpy.context.window_manager.popmenu_begin__internal("panel")  # never ended: that needs a window
        column = menu.layout.column()
        panel.draw(_PanelInstance(panel, column), bpy.context)
        return list(_widgets(column.introspect()))

    return draw


@contextmanager
def of_type(area: Any, kind: str) -> Iterator[None]:
    """An area turned into an editor of a kind meanwhile: reading a file in background keeps the areas, for all other tests."""
    before = area.type
    area.type = kind
    try:
        yield
    finally:
        area.type = before


def _widgets(items: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    for item in items:
        if "items" in item:
            yield from _widgets(item["items"])
        else:
            yield item
