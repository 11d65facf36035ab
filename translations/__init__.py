"""The extension in other languages, by Blender's own system: a file a language, as gettext's editors read and write it.

    .venv/bin/python translations/collect.py fr_FR

writes translations/fr_FR.po with every message of the extension, what was translated before kept. What has no translation is
shown in English.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import bpy

from .in_window import IN_WINDOW
from .po import Messages, read_po
from .templates import in_other_words

CORE = "Spectral Probe"
"""Context of the core's sentences, whose templates Blender cannot look up: what is put in is part of them."""


def languages() -> dict[str, Messages]:
    """What is translated into each language there is a file of."""
    files = sorted(Path(__file__).parent.glob("*.po"))
    return {file.stem: read_po(file.read_text("utf-8")) for file in files}


def of_core(sentence: str) -> str:
    """A sentence of the core in words of the window, and in Blender's language where reports are translated."""
    sentence = in_other_words(sentence, IN_WINDOW)
    templates = _core_templates(bpy.app.translations.locale)
    if not templates or not bpy.context.preferences.view.use_translate_reports:
        return sentence
    return in_other_words(sentence, templates)


@cache
def _core_templates(language: str) -> dict[str, str]:
    messages = languages().get(language, {})
    return {message: text for (context, message), text in messages.items() if context == CORE}


def register() -> None:
    """Make the translations known to Blender, once."""
    unregister()
    bpy.app.translations.register(__package__, languages())


def unregister() -> None:
    """Take them back."""
    bpy.app.translations.unregister(__package__)
    _core_templates.cache_clear()
