"""Writes reference.md: every panel, operator and setting as Blender knows them.

.venv/bin/python docs/manual/reference.py

Run it after a change of a label, a tooltip or a property; a test compares the page with what it would write.
"""

from __future__ import annotations

import math
import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PAGE = HERE / "reference.md"
MODULE = "bl_ext.user_default.spectral_probe"
_EDITORS = {
    "PROPERTIES": "Properties",
    "VIEW_3D": "3D Viewport, sidebar",
    "IMAGE_EDITOR": "Image Editor, sidebar",
}
_TABS = {"world": "World", "render": "Render", "material": "Material", "data": "Object Data (lamps)"}
_OWNERS = (("Scene", "scene"), ("Material", "material"), ("Light", "lamp"))
_KINDS = {"BOOLEAN": "on or off", "INT": "whole number", "FLOAT": "number", "STRING": "text"}
_SUBTYPES = {"FILE_PATH": "file", "DIR_PATH": "folder", "COLOR": "colour"}
_INTRODUCTION = """# Reference: panels, operators, settings

Written by `reference.py` from what Blender knows of the extension; the words are those of the tooltips. What the panels are for:
[panels.md](panels.md). Scripts call an operator as `bpy.ops.spectral_probe.NAME(...)` and set a setting by its path
([scripts.md](scripts.md)). Angles are shown in degrees and set in radians by scripts.
"""


def reference() -> str:
    """The page, of the extension that is enabled."""
    parts = [_INTRODUCTION, "## Panels\n", *_panels(), "\n## Operators\n", *_operators(), "\n## Settings\n"]
    return "\n".join([*parts, *_settings()]) + "\n"


def panels() -> list[Any]:
    """The extension's panels, those of presets left out, by place and name."""
    import bpy

    found = [getattr(bpy.types, name) for name in dir(bpy.types) if name.startswith("SPECTRAL_PROBE_PT_")]
    shown = [panel for panel in found if not panel.__name__.endswith("_presets")]
    return sorted(shown, key=lambda panel: (place_of(panel), panel.__name__))


def place_of(panel: Any) -> str:
    """Where a panel is, in Blender's words: editor > tab > panels above it."""
    import bpy

    parent = getattr(panel, "bl_parent_id", "")
    if parent:
        above = getattr(bpy.types, parent)
        return f"{place_of(above)} > {above.bl_label}"
    tab = _TABS.get(getattr(panel, "bl_context", ""), "") or getattr(panel, "bl_category", "")
    return f"{_EDITORS[panel.bl_space_type]} > {tab}"


def operators() -> list[Any]:
    """RNA types of the extension's operators, by name."""
    import bpy

    names = sorted(dir(bpy.ops.spectral_probe))
    return [getattr(bpy.ops.spectral_probe, name).get_rna_type() for name in names]


def verb_of(operator: Any) -> str:
    """Name of an operator as scripts write it."""
    return f"spectral_probe.{operator.identifier.removeprefix('SPECTRAL_PROBE_OT_')}"


def _panels() -> Iterator[str]:
    yield "| Where | Panel | |"
    yield "|---|---|---|"
    for panel in panels():
        yield f"| {place_of(panel)} | **{panel.bl_label}** | {_first(panel.__doc__ or '')} |"


def _first(text: str) -> str:
    return _cell(text.strip().splitlines()[0])


def _operators() -> Iterator[str]:
    for operator in operators():
        yield f"**{operator.name}** `{verb_of(operator)}`: {_sentence(operator.description)}"
        yield from _table("", operator.properties)
        yield ""


def _settings() -> Iterator[str]:
    import bpy

    for name, owner in _OWNERS:
        pointer = getattr(bpy.types, name).bl_rna.properties["spectral_probe"]
        yield f"### {name}: `{owner}.spectral_probe`"
        yield from _group("", pointer.fixed_type)


def _group(path: str, group: Any) -> Iterator[str]:
    """A table of a group, then its groups and lists."""
    yield from _table(path, group.properties)
    yield ""
    for item in group.properties:
        if item.type not in {"POINTER", "COLLECTION"} or item.is_hidden:
            continue
        inner = item.fixed_type
        if not inner.identifier.startswith("SPECTRAL_PROBE_PG_"):
            continue
        step = f"{path}{item.identifier}" + ("[...]" if item.type == "COLLECTION" else "")
        yield f"#### `{step}`\n\n{_sentence(_about(inner))}"
        yield from _group(f"{step}.", inner)


def _about(group: Any) -> str:
    """What the class of a group says of it."""
    import bpy

    return bpy.types.PropertyGroup.bl_rna_get_subclass_py(group.identifier).__doc__ or ""


def _table(path: str, properties: Any) -> Iterator[str]:
    rows = [item for item in properties if _is_plain(item)]
    if not rows:
        return
    yield "\n| Setting | Path | What it is | Values |"
    yield "|---|---|---|---|"
    for item in rows:
        text = _cell(_sentence(item.description))
        yield f"| {_cell(item.name)} | `{path}{item.identifier}` | {text} | {_cell(_values(item))} |"


def _is_plain(item: Any) -> bool:
    if item.identifier in {"rna_type", "name"} or item.is_hidden or item.type == "COLLECTION":
        return False
    if item.identifier in {"directory", "filepath"}:  # what a file browser fills
        return False
    return item.type != "POINTER" or not item.fixed_type.identifier.startswith("SPECTRAL_PROBE_PG_")


def _values(item: Any) -> str:
    """What a property can be, and what it is by default."""
    if item.type == "ENUM":
        items = item.enum_items_static or item.enum_items
        return "; ".join(f"`{one.identifier}` {one.name}" for one in items)
    if item.type == "POINTER":
        return item.fixed_type.name
    if item.type == "STRING":
        kind = _SUBTYPES.get(item.subtype, "text")
        return f"{kind}, `{item.default}`" if item.default else kind
    count = getattr(item, "array_length", 0)
    default = item.default_array[:] if count else item.default
    unit = _unit(item)
    return f"{_KINDS[item.type]}{f' x {count}' if count else ''}{_range(item)}, {_shown(default, item)}{unit}"


def _unit(item: Any) -> str:
    return {"LENGTH": " m", "ROTATION": "°", "TIME_ABSOLUTE": " s"}.get(getattr(item, "unit", ""), "")


def _range(item: Any) -> str:
    if item.type == "BOOLEAN":
        return ""
    low, high = item.hard_min, item.hard_max
    if abs(low) > 1e8 and abs(high) > 1e8:
        return ""
    if abs(high) > 1e8:
        return f" from {_shown(low, item)}"
    return f" {_shown(low, item)} to {_shown(high, item)}"


def _shown(value: Any, item: Any) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    if not isinstance(value, int | float):
        shown = [_shown(one, item) for one in value]
        return shown[0] if len(set(shown)) == 1 else ", ".join(shown)
    if getattr(item, "unit", "") == "ROTATION":
        value = math.degrees(value)
    return f"{value:.4g}"


def _sentence(text: str) -> str:
    text = " ".join(text.split())
    return f"{text}." if text and text[-1] not in ".?!" else text


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")


def main() -> int:
    """Enable the extension in a Blender of its own, and write the page."""
    with tempfile.TemporaryDirectory(prefix="reference_") as resources:
        os.environ["BLENDER_USER_RESOURCES"] = resources
        repository = Path(resources, "extensions", "user_default")
        repository.mkdir(parents=True)
        (repository / "spectral_probe").symlink_to(ROOT, target_is_directory=True)
        import bpy  # noqa: F401  (not before its folders are set; addon_utils is there once it is imported)
        import addon_utils  # isort: skip

        addon_utils.enable(MODULE, handle_error=_raise)
        PAGE.write_text(reference(), encoding="utf-8")
        addon_utils.disable(MODULE, handle_error=_raise)
    return 0


def _raise(error: Exception) -> None:
    raise error


if __name__ == "__main__":
    sys.exit(main())
