"""The camera of the library that took a photograph, by what its file calls it."""

from __future__ import annotations

import re
from collections.abc import Iterable

LIBRARY_CAMERAS = ("Nikon 5100 (NPL)", "Sigma SDMerill (NPL)", "Canon EOS 5D Mark II")
"""Cameras of the library, known here without loading colour-science; a test compares."""

_OTHER_NAMES = {"nikond5100": "nikon5100npl", "sigmasd1merrill": "sigmasdmerillnpl"}
"""Cameras that colour-science calls otherwise than their makers do."""


def library_camera(written: str, names: Iterable[str]) -> str | None:
    """The name among `names` that stands for what a file calls its camera, maker before model; None where there is none.

    Examples
    --------
    >>> known = ("Nikon 5100 (NPL)", "Canon EOS 5D Mark II", "Rec.709", "Sony_ILCE-7M3")
    >>> [library_camera(written, known) for written in ("NIKON CORPORATION NIKON D5100", "SONY ILCE-7M3", "Canon EOS 5D")]
    ['Nikon 5100 (NPL)', 'Sony_ILCE-7M3', None]
    """
    by_key = {_key(name): name for name in names}
    words = written.split()
    for start in range(len(words)):  # the maker may stand twice: NIKON CORPORATION NIKON D5100
        key = _key(" ".join(words[start:]))
        found = by_key.get(key) or by_key.get(_OTHER_NAMES.get(key, ""))
        if found is not None:
            return found
    return None


def _key(name: str) -> str:
    return re.sub(r"[^a-z0-9]", "", name.casefold())
