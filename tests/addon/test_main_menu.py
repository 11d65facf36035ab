"""Every operator can be found by name: Blender's search lists what stands in menus."""

from __future__ import annotations

from types import SimpleNamespace

import bpy

# Those that stand in another menu or list, or make no sense by their name alone.
ELSEWHERE = {
    "render_spectral": "the Render menu itself",
    "render_animation": "the Render menu itself",
    "render_and_compare": "the Render menu itself",
    "add_object": "Add > Spectral Metal",
    "move_photo": "the menu beside the list of photographs: it needs a target",
    "load_preset": "the menus of presets",
    "save_preset": "the menus of presets",
    "copy_report": "a button of each report: it needs to know which",
}


def lines(menu: type) -> list[dict]:
    """The lines of a menu."""
    layout = bpy.context.window_manager.popmenu_begin__internal("menu").layout.column()
    menu.draw(SimpleNamespace(layout=layout, operators=getattr(menu, "operators", ())), bpy.context)
    return layout.introspect()[0]["items"]


def label(verb: str) -> str:
    return getattr(bpy.ops.spectral_probe, verb).get_rna_type().name


def test_every_operator_stands_in_a_menu(in_extension):
    stages = in_extension("panels.main_menu").STAGES
    listed = [verb for stage in stages for verb, _ in stage.operators]
    assert len(listed) == len(set(listed))
    registered = {name for name in dir(bpy.ops.spectral_probe) if not name.startswith("_")}
    assert set(listed) | set(ELSEWHERE) == registered
    assert not set(listed) & set(ELSEWHERE)


def test_the_menus_draw_a_line_for_each(in_extension):
    menu = in_extension("panels.main_menu")
    assert len(lines(menu.SPECTRAL_PROBE_MT_main)) == len(menu.STAGES)
    for stage in menu.STAGES:
        drawn = [line["draw_string"] for line in lines(stage)]
        assert drawn == [text or label(verb) for verb, text in stage.operators]


def test_no_two_lines_are_called_the_same(in_extension):
    texts = []
    for stage in in_extension("panels.main_menu").STAGES:
        for verb, text in stage.operators:
            texts.append(text or label(verb))
    assert len(texts) == len(set(texts))
