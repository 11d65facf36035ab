"""Every text of the extension can be translated by Blender's own system, and what is translated fits."""

from __future__ import annotations

import ast
import importlib.util
import string
import sys
from pathlib import Path

import bpy
import pytest

ROOT = Path(__file__).resolve().parents[2]
LANGUAGES = sorted(path.stem for path in (ROOT / "translations").glob("*.po"))


@pytest.fixture(scope="module")
def collect():
    """The script for translators; it is not part of the product."""
    spec = importlib.util.spec_from_file_location("collect", ROOT / "translations" / "collect.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def messages(collect, extension):
    return collect.collected(extension)


@pytest.fixture(scope="module")
def texts(in_extension):
    return in_extension("translations.source_texts")


@pytest.fixture(scope="module")
def po(in_extension):
    return in_extension("translations.po")


def test_no_text_is_out_of_a_translations_reach(collect, texts):
    found = [text for file in collect.shown_files() for text in texts.unreachable(file, ROOT)]
    assert [f"{text.file}:{text.line} {text.message}" for text in found] == []


@pytest.mark.parametrize(
    "line",
    [
        'self.report({"INFO"}, f"{count} views")',
        'layout.label(text="Found " + name)',
        'layout.operator("x.y", text=f"Move to {name}")',
        'row(column, "Passes", f"{passes} at {samples} samples")',
        'cls.poll_message_set("{} are missing".format(count))',
        'self.tell("INFO", "no" if count == 0 else f"{count} views")',
        'self.report({"INFO"}, f"{rpt_(name)} was left out")',
    ],
)
def test_a_text_out_of_reach_is_noticed(texts, tmp_path, line):
    file = tmp_path / "x.py"
    file.write_text(line, "utf-8")
    assert len(list(texts.unreachable(file, tmp_path))) == 1


@pytest.mark.parametrize(
    "line",
    [
        'self.report({"INFO"}, rpt_("{count} views").format(count=2))',
        'row(column, "Error", f"{error:.2f} px")',
        'layout.label(text=f"{name} here", translate=False)',
        'row(column, iface_("Angle"), f"{angle:.1f}°")',
    ],
)
def test_what_can_be_translated_is_left_in_peace(texts, tmp_path, line):
    file = tmp_path / "x.py"
    file.write_text(line, "utf-8")
    assert list(texts.unreachable(file, tmp_path)) == []


def test_texts_are_found_in_the_code(texts, tmp_path):
    file = tmp_path / "x.py"
    file.write_text(
        'self.tell("INFO", "One" if one else rpt_("Many {n}").format(n=2))\n'
        'layout.operator("a.b", text="Go There")\n'
        'raise CaptureError(f"View {number} has no {thing.name}.")\n'
        'yield Progress(0.5, f"Reading {path.name}")\n',
        "utf-8",
    )
    assert {(text.context, text.message) for text in texts.texts_in(file, tmp_path)} == {
        ("*", "One"),
        ("*", "Many {n}"),
        ("Operator", "Go There"),
    }
    assert [text.message for text in texts.sentences_in(file, tmp_path)] == [
        "View {0} has no {1}.",
        "Reading {0}",
    ]


def test_the_collection_has_all_labels_tooltips_and_items(collect, messages, extension):
    for kind in collect.extension_classes(extension):
        if issubclass(kind, bpy.types.Operator):
            assert ("Operator", kind.bl_label) in messages
            assert ("*", kind.__doc__) in messages
        elif issubclass(kind, (bpy.types.Panel, bpy.types.Menu)):
            assert ("*", kind.bl_label) in messages
    for text in (
        "Colour error CIEDE2000",
        "As Few as Needed",
        "Probe built: {blind:.1%} blind, {seconds:.1f} s",
    ):
        assert any(message.startswith(text) for _, message in messages), text


def test_constant_strings_of_translated_calls_are_in_the_collection(collect, messages):
    """Counted in another way than the script does: every first argument of rpt_, iface_, tip_, n_."""
    known = {message for _, message in messages}
    for file in collect.shown_files():
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if not isinstance(node, ast.Call) or getattr(node.func, "id", "") not in {
                "rpt_",
                "iface_",
                "tip_",
                "n_",
            }:
                continue
            assert not isinstance(node.args[0], (ast.JoinedStr, ast.BinOp)), f"{file}:{node.lineno}"
            if isinstance(node.args[0], ast.Constant) and any(map(str.isalpha, node.args[0].value)):
                assert node.args[0].value in known, f"{file}:{node.lineno}"


def test_a_language_file_holds_what_was_written(collect, po):
    messages = {("*", "Ball"): ["x"], ("Operator", 'Say "\\no"'): ["y"], ("*", "Two\nlines"): ["z"]}
    translated = {
        ("*", "Ball"): "Kugel",
        ("Operator", 'Say "\\no"'): 'Sag "\\nein"',
        ("*", "Two\nlines"): "Zwei\nZeilen",
    }
    assert po.read_po(collect.po_text(messages, translated, "de_DE")) == translated
    assert po.read_po(collect.po_text(messages, {}, "de_DE")) == {}


@pytest.mark.parametrize("language", LANGUAGES)
def test_translations_are_of_messages_that_there_are(messages, po, language):
    translated = po.read_po((ROOT / "translations" / f"{language}.po").read_text("utf-8"))
    gone = [key for key in translated if key not in messages]
    assert gone == [], f"renew it: .venv/bin/python translations/collect.py {language} --trim"


@pytest.mark.parametrize("language", LANGUAGES)
def test_translations_put_in_the_same(po, language):
    translated = po.read_po((ROOT / "translations" / f"{language}.po").read_text("utf-8"))
    parse = string.Formatter().parse
    for (_, message), text in translated.items():
        wanted = sorted((name, form) for _, name, form, _ in parse(message) if name is not None)
        given = sorted((name, form) for _, name, form, _ in parse(text) if name is not None)
        assert wanted == given, message


@pytest.mark.parametrize("language", LANGUAGES)
def test_labels_and_buttons_are_translated_altogether(collect, extension, po, language):
    translated = po.read_po((ROOT / "translations" / f"{language}.po").read_text("utf-8"))
    missing = []
    for kind in collect.extension_classes(extension):
        context = "Operator" if issubclass(kind, bpy.types.Operator) else "*"
        if hasattr(kind, "bl_label") and (context, kind.bl_label) not in translated:
            missing.append(kind.bl_label)
    assert missing == []


def test_sentences_of_the_core_are_translated_by_their_templates(in_extension, monkeypatch):
    translations = in_extension("translations")
    templates = {
        "View {0} has no photograph.": "Ansicht {0} hat kein Foto.",
        "{0}": "alles",
        "{0} of {1}": "{1}, davon {0}",
        "Stop.": "Halt.",
    }
    monkeypatch.setattr(translations, "_core_templates", lambda _language: templates)
    monkeypatch.setattr(bpy.context.preferences.view, "use_translate_reports", True)
    assert translations.of_core("View 2 has no photograph.") == "Ansicht 2 hat kein Foto."
    assert translations.of_core("3 of 4") == "4, davon 3"
    assert translations.of_core("Stop.") == "Halt."
    assert translations.of_core("Something else") == "Something else"


def test_words_of_the_window_are_for_sentences_of_the_core(in_extension, texts):
    in_window, templates = in_extension("translations").IN_WINDOW, in_extension("translations.templates")
    files = sorted((ROOT / "spectral_probe").rglob("*.py"))
    said = {text.message for file in files for text in texts.sentences_in(file, ROOT)}
    for sentence, words in in_window.items():
        assert sentence in said, sentence
        assert set(templates.places(sentence)) == set(templates.places(words)), sentence
        assert "--" not in words, words


def test_nobody_before_a_window_is_told_to_edit_a_file(in_extension):
    of_core = in_extension("translations").of_core
    told = of_core(
        "a.jpg does not say its focal length. Add focal_px, or focal_mm and sensor_width_mm, to [camera] in the capture file."
    )
    assert (
        told
        == "a.jpg does not say its focal length. Give Focal Length in World > Spectral Probe > Capture > Camera."
    )


def test_braces_in_a_sentence_stay(in_extension):
    in_other_words = in_extension("translations.templates").in_other_words
    assert in_other_words("{0}.exr is gone", {"{0} is gone": "{0} ist weg"}) == "{0}.exr ist weg"


def test_translations_leave_with_the_extension(in_extension):
    translations = in_extension("translations")
    translations.register()  # once more than Blender does
    translations.unregister()
    translations.register()
    assert "collect" not in {name.rpartition(".")[2] for name in sys.modules if name.startswith("bl_ext")}
