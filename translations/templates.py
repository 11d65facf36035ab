"""Sentences of the core, which knows no Blender, in another language: found again by their templates.

The core says `f"View {number} has no photograph."`; a translator is given `View {0} has no photograph.`, in which the numbers
count what is put in. A sentence that was made so fits its template, and what fits in the braces goes into the translation.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache

_PLACE = re.compile(r"\{(\d+)\}")


def in_other_words(sentence: str, templates: Mapping[str, str]) -> str:
    """A sentence by the translation of its template; as it is where it fits none.

    Parameters
    ----------
    sentence
        What the core said.
    templates
        Translations by templates; `{0}`, `{1}`, ... stand for what is put in, in any order in a translation.

    Examples
    --------
    >>> in_other_words("View 2 has no photograph.", {"View {0} has no photograph.": "Ansicht {0} hat kein Foto."})
    'Ansicht 2 hat kein Foto.'
    >>> in_other_words("Unheard of.", {})
    'Unheard of.'
    """
    if sentence in templates:
        return templates[sentence]
    for template in sorted(templates, key=_fixed_letters, reverse=True):  # the one that says most of it
        put_in = _fitted(sentence, template)
        if put_in is not None:
            parts = _PLACE.split(templates[template])
            parts[1::2] = [put_in[number] for number in parts[1::2]]
            return "".join(parts)
    return sentence


def places(template: str) -> list[str]:
    """The numbers of what is put in, in order.

    Examples
    --------
    >>> places("{0} of {1}")
    ['0', '1']
    """
    return sorted(_PLACE.findall(template))


@cache
def _fixed_letters(template: str) -> int:
    return len(_PLACE.sub("", template))


@cache
def _pattern(template: str) -> tuple[re.Pattern[str], tuple[str, ...]] | None:
    """What a sentence made by a template looks like, and the numbers of what is put in; None where nothing is."""
    parts = _PLACE.split(template)  # text, number, text, number, text
    numbers = tuple(parts[1::2])
    if not numbers or not _fixed_letters(template):
        return None
    return re.compile("(.*?)".join(re.escape(text) for text in parts[::2]), re.DOTALL), numbers


def _fitted(sentence: str, template: str) -> dict[str, str] | None:
    pattern = _pattern(template)
    if pattern is None:
        return None
    found = pattern[0].fullmatch(sentence)
    return None if found is None else dict(zip(pattern[1], found.groups(), strict=True))
