"""Translations as gettext's editors write them: a .po file, of which Blender is given a dictionary."""

from __future__ import annotations

import re

type Messages = dict[tuple[str, str], str]
"""Translations by context and message."""

_LINE = re.compile(r'(?:(msgctxt|msgid|msgstr)\s+)?"((?:[^"\\]|\\.)*)"\s*')
_ESCAPED = re.compile(r"\\(.)")
_MEANING = {"n": "\n", "t": "\t"}


def read_po(text: str) -> Messages:
    """The translations in a .po file, without messages that have none, or one that is marked as doubtful.

    Examples
    --------
    >>> read_po('''
    ... msgctxt "*"
    ... msgid "Ball"
    ... msgstr "Kugel"
    ... ''')
    {('*', 'Ball'): 'Kugel'}
    """
    messages: Messages = {}
    for entry in re.split(r"\n\s*\n", text):
        fields = {"msgctxt": "*", "msgid": "", "msgstr": ""}
        field = ""
        for line in entry.splitlines():
            found = _LINE.fullmatch(line)
            if found is None:
                continue  # a comment, or what is no longer in use
            if found[1]:
                field = found[1]
                fields[field] = ""
            text = found[2]
            fields[field] += (
                _ESCAPED.sub(lambda code: _MEANING.get(code[1], code[1]), text) if "\\" in text else text
            )
        if fields["msgid"] and fields["msgstr"] and "#, fuzzy" not in entry:
            messages[fields["msgctxt"], fields["msgid"]] = fields["msgstr"]
    return messages
