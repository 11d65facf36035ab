"""Collect every message of the extension for a translator, and write or renew a language's file.

    .venv/bin/python translations/collect.py fr_FR        translations/fr_FR.po, all messages; what was translated before is kept
    .venv/bin/python translations/collect.py fr_FR --trim the same without the messages that have no translation yet

Labels, tooltips and the items of menus come from Blender's own description of the registered classes, texts made at run time from
the code (source_texts.py). Messages that are no longer in the extension leave the file.
"""

from __future__ import annotations

import importlib
import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
MODULE = "bl_ext.user_default.spectral_probe"
_SHOWN = ("operators", "panels", "settings")
_NOT_IN_THE_WINDOW = {
    "demo.py", "demo_plate.py", "terminal.py", "command_line.py", "command_backplate.py", "command_frames.py", "command_farm.py",
}  # fmt: skip

type Key = tuple[str, str]


def collected(extension: ModuleType) -> dict[Key, list[str]]:
    """Where each message (context and text) of the enabled extension is from; the places in the order of the code."""
    found: dict[Key, list[str]] = {}
    for context, message, place in (*_of_classes(extension), *_of_code(extension)):
        if message:
            found.setdefault((context, message), []).append(place)
    return found


def shown_files() -> list[Path]:
    """Files with texts that are shown in the window."""
    files = [*ROOT.glob("*.py"), *(file for name in _SHOWN for file in (ROOT / name).rglob("*.py"))]
    return sorted(file for file in files if file.name not in _NOT_IN_THE_WINDOW and file.name != "run.py")


def extension_classes(extension: ModuleType) -> list[Any]:
    """The registered classes of the extension, by name."""
    import bpy

    def below(kind: type) -> Iterator[type]:
        for child in kind.__subclasses__():
            yield child
            yield from below(child)

    prefix = f"{extension.__name__}."
    known = {kind for kind in below(bpy.types.bpy_struct) if kind.__module__.startswith(prefix)}
    return sorted(
        (kind for kind in known if getattr(kind, "is_registered", False)), key=lambda kind: kind.__name__
    )


def _of_classes(extension: ModuleType) -> Iterator[tuple[str, str, str]]:
    import bpy

    for kind in extension_classes(extension):
        place, rna = kind.__name__, kind.bl_rna
        is_operator = issubclass(kind, bpy.types.Operator)
        if is_operator:
            group, verb = kind.bl_idname.split(".")
            rna = getattr(getattr(bpy.ops, group), verb).get_rna_type()
            yield rna.translation_context, rna.name, place
            yield "*", rna.description, place
        elif hasattr(kind, "bl_label"):
            yield "*", kind.bl_label, place
            yield "*", (kind.__doc__ or "") if issubclass(kind, bpy.types.Menu) else "", place
            yield "*", getattr(kind, "bl_category", ""), place
        own = set(rna.properties.keys()) - set(rna.base.properties.keys() if rna.base else ())
        for name in sorted(own - {"rna_type", "name"} if is_operator else own - {"rna_type"}):
            yield from _of_property(rna.properties[name], f"{place}.{name}")


def _of_property(prop: Any, place: str) -> Iterator[tuple[str, str, str]]:
    if prop.is_hidden and not prop.description:
        return
    context = prop.translation_context
    yield context, prop.name if prop.name != prop.identifier else "", place
    yield "*", prop.description, place
    for item in getattr(prop, "enum_items_static", ()):
        yield context, item.name, f"{place}.{item.identifier}"
        yield "*", item.description, f"{place}.{item.identifier}"


def _of_code(extension: ModuleType) -> Iterator[tuple[str, str, str]]:
    texts = importlib.import_module(".translations.source_texts", extension.__name__)
    translations = importlib.import_module(".translations", extension.__name__)
    core, in_window = translations.CORE, translations.IN_WINDOW
    for file in shown_files():
        for text in texts.texts_in(file, ROOT):
            yield text.context, text.message, text.file
    for file in (*sorted((ROOT / "spectral_probe").rglob("*.py")), *shown_files()):
        for text in texts.sentences_in(file, ROOT):
            yield core, in_window.get(text.message, text.message), text.file


def po_text(messages: dict[Key, list[str]], translated: dict[Key, str], language: str) -> str:
    """The text of a language's file: what gettext's editors read and write."""
    head = (
        'msgid ""',
        'msgstr ""',
        _quoted("Project-Id-Version: Spectral Probe\n"),
        _quoted(f"Language: {language}\n"),
        _quoted("Content-Type: text/plain; charset=UTF-8\n"),
    )
    entries = ["\n".join(head)]
    for (context, message), places in messages.items():
        text = translated.get((context, message), "")
        lines = (
            f"#: {places[0]}",
            f"msgctxt {_quoted(context)}",
            f"msgid {_quoted(message)}",
            f"msgstr {_quoted(text)}",
        )
        entries.append("\n".join(lines))
    return "\n\n".join(entries) + "\n"


def _quoted(value: str) -> str:
    inside = value.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{inside}"'


def main(words: list[str]) -> None:
    """Write a language's file."""
    language, trim = words[0], "--trim" in words
    extension = _enabled()
    messages = collected(extension)
    path = ROOT / "translations" / f"{language}.po"
    po = importlib.import_module(".translations.po", MODULE)
    translated = po.read_po(path.read_text("utf-8")) if path.is_file() else {}
    if trim:
        messages = {key: places for key, places in messages.items() if translated.get(key)}
    path.write_text(po_text(messages, translated, language), "utf-8")
    done = sum(bool(translated.get(key)) for key in messages)
    sys.stdout.write(f"{path}: {len(messages)} messages, {done} translated\n")


def _enabled() -> ModuleType:
    """The extension, enabled in Blender's empty user folders."""
    folder = Path(tempfile.mkdtemp(prefix="spectral_probe_words_"))
    os.environ["BLENDER_USER_RESOURCES"] = str(folder)
    repository = folder / "extensions" / "user_default"
    repository.mkdir(parents=True)
    (repository / "spectral_probe").symlink_to(ROOT, target_is_directory=True)
    import bpy  # not before its folders are set

    bpy.ops.preferences.addon_enable(module=MODULE)
    return sys.modules[MODULE]


if __name__ == "__main__":
    main(sys.argv[1:])
