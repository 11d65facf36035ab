"""Texts that stand in the code, found without running it: what Blender translates where it is drawn or reported.

A text made at run time can be translated only where its fixed part is one string (`rpt_("{count} views").format(...)`);
`unreachable` finds the others. Strings in tables are marked where they stand: `n_("Silver Ball")`.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

TRANSLATES = ("iface_", "rpt_", "tip_", "n_", "data_")
"""Functions of bpy.app.translations, by the short names that we import them under."""

CALLS: dict[str, dict[int, str]] = {
    **{name: {0: ""} for name in (*TRANSLATES, "poll_message_set")},
    "report": {1: "message"},
    "invoke_confirm": {2: "title", 3: "message", 4: "confirm_text"},
    "invoke_props_dialog": {3: "title", 4: "confirm_text"},
    # ours
    "tell": {1: "text"},
    "row": {1: "heading", 2: ""},
    "cells": dict.fromkeys(range(1, 8), ""),
    "paragraph": {2: ""},
    "Progress": {1: ""},
    "has_probe": {2: "message"},
    "has_render_files": {3: "message"},
    "_has_file": {3: "message"},
}
"""Arguments that are shown, by function: their place and keyword."""

KEYWORDS = {"text", "heading", "placeholder", "text_confirm"}
"""Keywords of the functions of a layout that are shown."""

LAYOUT = {
    *(
        "label",
        "prop",
        "prop_enum",
        "prop_menu_enum",
        "prop_search",
        "prop_tabs_enum",
        "operator",
        "operator_enum",
    ),
    *("operator_menu_enum", "menu", "menu_contents", "popover", "panel", "progress", "row", "column"),
}

_UNITS = {"px", "sr", "nm", "EV", "ISO", "EXIF", "MB", "min", "mm", "sRGB"}
_WORD = re.compile(r"[^\W\d_]{2,}")
_ERROR = re.compile(r"(SpectralProbe|Capture|Photograph|Outline|SpectralData|FileFormat|Render)Error")


@dataclass(frozen=True)
class Text:
    """A text in the code, and where."""

    message: str
    context: str
    file: str
    line: int


def texts_in(file: Path, root: Path) -> Iterator[Text]:
    """Texts that are shown out of one file, with the context that Blender looks them up in."""
    for call, shown in _shown(ast.parse(file.read_text("utf-8"))):
        for node in _choices(shown):
            if not isinstance(node, ast.Constant) or not isinstance(node.value, str):
                continue
            if _is_words(node.value) or _name(call) in TRANSLATES:
                context = _context(call)
                yield Text(node.value, context, file.relative_to(root).as_posix(), node.lineno)


def sentences_in(file: Path, root: Path) -> Iterator[Text]:
    """Templates of errors, warnings and steps of jobs that nothing translates where they are made; `{0}`, ... is put in."""
    for call in _calls(ast.parse(file.read_text("utf-8"))):
        name = _name(call)
        if not _ERROR.fullmatch(name) and name not in {"Progress", "append"}:
            continue
        place = 1 if name == "Progress" else 0
        for node in _choices(call.args[place]) if len(call.args) > place else ():
            template = _template(node)
            if template is not None and _is_words(template) and (name != "append" or " " in template):
                yield Text(template, "", file.relative_to(root).as_posix(), node.lineno)


def unreachable(file: Path, root: Path) -> Iterator[Text]:
    """Texts that no translation can reach: words in f-strings, in sums, or formatted before they are translated."""
    for _, shown in _shown(ast.parse(file.read_text("utf-8"))):
        for node in _choices(shown):
            fixed = _fixed_part(node)
            if fixed is not None and _is_words(fixed):
                yield Text(fixed, "", file.relative_to(root).as_posix(), node.lineno)


def _shown(tree: ast.AST) -> Iterator[tuple[ast.Call, ast.expr]]:
    for call in _calls(tree):
        name = _name(call)
        if any(k.arg == "translate" and getattr(k.value, "value", True) is False for k in call.keywords):
            continue
        places = CALLS.get(name, {})
        for place, argument in enumerate(call.args):
            if place in places:
                yield call, argument
        for keyword in call.keywords:
            if keyword.arg in places.values() or (name in LAYOUT and keyword.arg in KEYWORDS):
                yield call, keyword.value


def _context(call: ast.Call) -> str:
    """Where Blender looks a text up: operators' names are apart from all others."""
    if _name(call) in TRANSLATES:
        return str(getattr(call.args[1], "value", "*")) if len(call.args) > 1 else "*"
    return "Operator" if _name(call) in {"operator", "operator_menu_enum"} else "*"


def _calls(tree: ast.AST) -> Iterator[ast.Call]:
    return (node for node in ast.walk(tree) if isinstance(node, ast.Call))


def _name(call: ast.Call) -> str:
    return getattr(call.func, "id", getattr(call.func, "attr", ""))


def _choices(node: ast.expr) -> Iterator[ast.expr]:
    """An expression, or each that it may be: `a if b else c`, `a or b`."""
    if isinstance(node, ast.IfExp):
        yield from _choices(node.body)
        yield from _choices(node.orelse)
    elif isinstance(node, ast.BoolOp):
        for value in node.values:
            yield from _choices(value)
    else:
        yield node


def _fixed_part(node: ast.expr) -> str | None:
    """The words in a text that is put together there; None where it is not."""
    if isinstance(node, ast.JoinedStr):
        return " ".join(part.value for part in node.values if isinstance(part, ast.Constant))
    if isinstance(node, ast.BinOp):
        parts = [getattr(side, "value", None) for side in (node.left, node.right)]
        return " ".join([part for part in parts if isinstance(part, str)] + [_fixed_part(node.left) or ""])
    if isinstance(node, ast.Call) and _name(node) in {"format", "join"}:
        owner = node.func.value if isinstance(node.func, ast.Attribute) else None
        return owner.value if isinstance(owner, ast.Constant) else None
    return None


def _template(node: ast.expr) -> str | None:
    """A constant as it is, an f-string with numbers for what is put in, a sum of these; None for anything else."""
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else None
    if isinstance(node, ast.JoinedStr):
        number, parts = 0, []
        for part in node.values:
            if isinstance(part, ast.Constant):
                parts.append(part.value)
            else:
                parts.append(f"{{{number}}}")
                number += 1
        return "".join(parts)
    return None


def _is_words(text: str) -> bool:
    bare = re.sub(r"\{[^}]*\}", " ", text)
    return any(word not in _UNITS for word in _WORD.findall(bare)) or bare.strip() in {"95 %"}
