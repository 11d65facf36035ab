"""Labels and tooltips as Blender writes its own."""

from __future__ import annotations

import bpy
import pytest

SMALL = {
    "a",
    "an",
    "and",
    "as",
    "at",
    "by",
    "for",
    "from",
    "in",
    "of",
    "on",
    "or",
    "the",
    "to",
    "with",
    "xy",
    "sRGB",
}


@pytest.fixture(scope="module")
def shown(extension):
    """Labels, and tooltips, of all that is registered: where, and text."""
    labels, tooltips = [], []
    prefix = f"{extension.__name__}."
    kinds = (bpy.types.Operator, bpy.types.Panel, bpy.types.Menu, bpy.types.PropertyGroup)
    for kind in (kind for base in kinds for kind in base.__subclasses__()):
        if not kind.__module__.startswith(prefix) or not kind.is_registered:
            continue
        labels.append((kind.__name__, getattr(kind, "bl_label", "")))
        if issubclass(kind, (bpy.types.Operator, bpy.types.Menu)):
            tooltips.append((kind.__name__, kind.__doc__))
        for prop in kind.bl_rna.properties:
            if prop.identifier in kind.__annotations__ and not prop.identifier.startswith("bl_"):
                place = f"{kind.__name__}.{prop.identifier}"
                labels.append((place, prop.name))
                tooltips.append((place, prop.description))
                for item in getattr(prop, "enum_items_static", ()):
                    labels.append((f"{place}.{item.identifier}", item.name))
                    tooltips.append((f"{place}.{item.identifier}", item.description))
    return labels, tooltips


def test_labels_are_in_title_case(shown):
    bad = [
        (place, label)
        for place, label in shown[0]
        if label != place.rpartition(".")[2]  # fields that are never shown have no name
        and any(word[0].islower() and word not in SMALL for word in label.split())
    ]
    assert bad == []


def test_tooltips_have_no_full_stop_and_no_words_of_the_command_line(shown):
    bad = [(place, text) for place, text in shown[1] if text.rstrip().endswith(".") or " --" in text]
    assert bad == []


@pytest.mark.usefixtures("extension")
def test_every_operator_says_what_it_does():
    for verb in dir(bpy.ops.spectral_probe):
        assert len(getattr(bpy.ops.spectral_probe, verb).get_rna_type().description) > 10, verb
