"""The library as a list, and what choosing from it makes of materials and lamps."""

import bpy
import numpy as np
import pytest

pytestmark = pytest.mark.usefixtures("scene")


@pytest.fixture
def material():
    made = bpy.data.materials.new("thing")
    bpy.context.object.data.materials.clear()
    bpy.context.object.data.materials.append(made)
    return made


@pytest.fixture(scope="module")
def shelf(in_extension):
    """The swatches under FL11, computed once for all; of the pages, which the core's tests read all, those searched for here."""
    bpy.ops.wm.read_homefile(use_empty=False, use_factory_startup=True)
    settings = bpy.context.scene.spectral_probe.swatches
    settings.light, settings.lamp = "LAMP", "FL11"
    swatches = in_extension("spectral_probe.spectra.swatches")
    pages = [page for words in (["gold"], ["bk7"]) for page in swatches.search_pages(words)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(swatches, "search_pages", lambda _words: pages)
        assert bpy.ops.spectral_probe.show_swatches() == {"FINISHED"}
    shelf = in_extension("operators.bridge.swatches").SwatchShelf
    yield shelf
    shelf.clear()


@pytest.fixture
def listed(shelf, scene):  # noqa: ARG001  # a new file first
    """The list in this file."""
    shown = bpy.context.window_manager.spectral_probe_swatches
    shelf.fill(shown, shelf._named, shelf._pages, "FL11")
    return shown


@pytest.fixture
def choose():
    return bpy.ops.spectral_probe.choose_spectrum


def shader(material, kind="BSDF_PRINCIPLED"):
    return next(node for node in material.node_tree.nodes if node.type == kind)


def surface(material):
    return material.node_tree.get_output_node("CYCLES").inputs["Surface"].links[0].from_node


def test_every_entry_is_listed_with_its_icon(listed, shelf):
    items = listed.items
    assert listed.light == "FL11"
    assert {item.kind for item in items} == {"METAL", "GLASS", "DISPERSIVE", "REFLECTANCE", "LAMP"}
    assert {item.name for item in items} <= set(shelf._icons)  # without a window icons have no number
    assert shelf.icon_of("METAL|nothing") == 0


def test_the_icon_has_the_colour_of_the_swatch(shelf, in_extension):
    swatches = in_extension("spectral_probe.spectra.swatches")
    lamp = in_extension("spectral_probe.spectra.library").lamp_spectrum("FL11")
    gold = next(swatch for swatch in swatches.library_swatches(lamp) if swatch.key == "METAL|Au")
    icon = shelf._icons["METAL|Au"]
    pixels = np.array(icon.icon_pixels_float).reshape(*icon.icon_size, 4)
    assert pixels[8, 8, :3] == pytest.approx(gold.rgb, abs=1 / 255)
    assert pixels[8, 8, 3] == 1.0


def test_search_narrows_and_reaches_all_of_refractiveindex_info(listed):
    shown = listed
    named = len(shown.items)
    shown.search = "gold"
    names = [item.entry for item in shown.items if item.kind == "METAL"]
    assert names[0] == "Au", "what the library names itself goes first"
    assert "main/Au/Olmon-ev" in names
    shown.search = "hikari bk7"
    assert "popular_glass/BK7/HIKARI" in [item.entry for item in shown.items if item.kind == "DISPERSIVE"]
    shown.search = "nothing like that"
    assert len(shown.items) == 0
    shown.search = ""
    assert len(shown.items) == named


def test_choosing_in_the_list_sets_the_material(listed, material):
    items = listed.items
    material.spectral_probe.kind = "METAL"
    assert items[material.spectral_probe.chosen_surface].entry == "Au"
    material.spectral_probe.chosen_surface = items.find("METAL|Cu")
    assert material.spectral_probe.metal == "Cu"
    assert items[material.spectral_probe.chosen_surface].entry == "Cu"
    assert shader(material).inputs["Metallic"].default_value == 1.0
    bpy.context.scene.spectral_probe.swatches.set_look = False
    before = tuple(shader(material).inputs["Base Color"].default_value)
    material.spectral_probe.chosen_surface = items.find("METAL|Ag")
    assert material.spectral_probe.metal == "Ag"
    assert tuple(shader(material).inputs["Base Color"].default_value) == before


def test_a_metal_looks_like_itself(material, choose, in_extension):
    assert choose(kind="METAL", entry="Au") == {"FINISHED"}
    facing, tint = in_extension("operators.bridge.rgb_twin").metal_colours("Au")
    node = shader(material)
    assert node.inputs["Base Color"].default_value[:3] == pytest.approx(facing)
    assert node.inputs["Specular Tint"].default_value[:3] == pytest.approx(tint)
    assert (material.spectral_probe.kind, material.spectral_probe.metal) == ("METAL", "Au")
    assert material.diffuse_color[:3] == pytest.approx(facing)


def test_the_look_can_be_left_alone(material, choose):
    before = tuple(shader(material).inputs["Base Color"].default_value)
    choose(kind="METAL", entry="Au", set_look=False)
    assert material.spectral_probe.metal == "Au"
    assert tuple(shader(material).inputs["Base Color"].default_value) == before


def test_what_is_linked_and_what_exists_stays(material, choose):
    tree, node = material.node_tree, shader(material)
    picture = tree.nodes.new("ShaderNodeTexImage")
    tree.links.new(picture.outputs["Color"], node.inputs["Base Color"])
    choose(kind="METAL", entry="Cu")
    assert node.inputs["Base Color"].links[0].from_node == picture
    assert node.inputs["Metallic"].default_value == 1.0
    choose(kind="GLASS", entry="green")  # a filter: a Principled shader is none, so one is added
    assert surface(material).type == "BSDF_TRANSPARENT"
    assert {picture, node} <= set(tree.nodes)
    assert node.inputs["Base Color"].links[0].from_node == picture


@pytest.mark.parametrize(
    ("kind", "entry", "field", "expected"),
    [
        ("REFLECTANCE", "ColorChecker N Ohta: red", "Metallic", 0.0),
        ("DISPERSIVE", "SF11", "Transmission Weight", 1.0),
        ("DISPERSIVE", "SF11", "IOR", 1.7845),
    ],
)
def test_every_kind_fits_the_ordinary_shader(kind, entry, field, expected, material, choose):
    choose(kind="METAL", entry="Au")
    choose(kind=kind, entry=entry)
    assert surface(material).inputs[field].default_value == pytest.approx(expected, abs=2e-3)


@pytest.mark.usefixtures("material")
def test_what_was_chosen_renders_spectrally(choose, in_extension):
    spectral = in_extension("operators.bridge.materials").spectral_materials
    for kind, entry in (
        ("METAL", "brass"),
        ("REFLECTANCE", "BabelColor Average: blue"),
        ("GLASS", "red"),
        ("DISPERSIVE", "diamond"),
        ("DISPERSIVE", "popular_glass/BK7/HOYA"),
        ("METAL", "Gold: main/Au/Olmon-ev"),
    ):
        choose(kind=kind, entry=entry)
        with spectral(bpy.context.scene, one_wavelength=True) as materials:
            assert materials.spectra or materials.dispersive, (kind, entry)


def test_a_lamp_takes_its_colour_and_keeps_its_luminance(choose):
    bpy.ops.object.light_add(type="AREA")
    lamp = bpy.context.object.data
    lamp.energy = 100.0
    choose(kind="LAMP", entry="A")
    weights = np.array([0.2126, 0.7152, 0.0722])
    assert (lamp.spectral_probe.light, lamp.spectral_probe.lamp) == ("LAMP", "A")
    assert lamp.color[0] > lamp.color[1] > lamp.color[2]
    assert lamp.energy * (weights @ np.array(lamp.color[:])) == pytest.approx(100.0, rel=1e-3)
    with pytest.raises(RuntimeError, match="is a lamp"):
        choose(kind="METAL", entry="Au")


def test_an_object_without_a_material_gets_one(choose):
    bpy.context.object.data.materials.clear()
    choose(kind="METAL", entry="Ti")
    assert bpy.context.object.active_material.spectral_probe.metal == "Ti"


def test_an_unknown_entry_changes_nothing(material, choose):
    with pytest.raises(RuntimeError, match="Did you mean"):
        choose(kind="METAL", entry="Goldd")
    assert material.spectral_probe.kind == "RGB"


@pytest.mark.usefixtures("listed")
def test_the_panel_draws_the_list(material, drawn):
    panel = bpy.types.SPECTRAL_PROBE_PT_material_swatches
    assert drawn(panel, material=material) == [], "from colours: nothing measured to choose"
    material.spectral_probe.kind = "METAL"
    texts = [widget.get("draw_string", "") for widget in drawn(panel, material=material)]
    assert any("under FL11" in text for text in texts)
    assert any("Johnson" in text for text in texts)


def test_the_add_menu_has_the_objects_once(extension):
    menu = bpy.types.VIEW3D_MT_add
    extension.unregister()
    extension.register()
    ours = [draw for draw in menu.draw._draw_funcs if draw.__name__ == "draw_add_menu"]
    assert len(ours) == 1
    bpy.ops.spectral_probe.add_object(kind="GROUP", size=2.0)
    names = {thing.name for thing in bpy.context.selected_objects}
    assert names == {"Gold Pedestal", "Silver Ball", "Copper Ball"}
    assert bpy.context.object.dimensions.z == pytest.approx(1.0, abs=0.01)
