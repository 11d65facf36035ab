"""The photograph and the outline over it: kept by the view, drawn where they are, edited by hand."""

import math

import bpy
import numpy as np
import pytest

ops = bpy.ops.spectral_probe


@pytest.fixture
def imported(settings, capture_file):
    assert ops.import_capture(filepath=str(capture_file)) == {"FINISHED"}
    return settings


class Region:
    """A region as Blender's: `region_to_view` puts the far corner at the last pixel's index."""

    def __init__(self, width, height, view):
        self.width, self.height, self._view = width, height, view
        self.view2d = self
        self.x, self.y = 40, 30

    def region_to_view(self, x, y):
        left, bottom, right, top = self._view
        return (
            left + (right - left) * x / (self.width - 1),
            bottom + (top - bottom) * y / (self.height - 1),
        )


@pytest.mark.parametrize(
    "view",
    [(0.0, 0.0, 1.0, 1.0), (-0.3, -1.2, 2.7, 1.8), (0.412, 0.5, 0.4125, 0.50045), (-40.0, -20.0, 41.0, 21.0)],
)
def test_pixels_of_the_photograph_come_back_from_the_region(in_extension, view):
    image_space = in_extension("operators.bridge.image_space")
    space = image_space.ImageSpace.of(Region(1139, 751, view), (6000, 4000)).moved((3.25, -1.5))
    for place in np.random.default_rng(2).uniform(-500, 6500, (50, 2)):
        np.testing.assert_allclose(space.to_photograph(*space.to_region(*place)), place, atol=1e-6)


def test_the_photograph_is_upright_and_its_corner_is_the_images_top_left(in_extension):
    space_of = in_extension("operators.bridge.image_space").ImageSpace.of
    space = space_of(Region(600, 400, (0.0, 0.0, 1.0, 1.0)), (300, 200))
    np.testing.assert_allclose(space.to_region(0, 0), (0, 400))
    np.testing.assert_allclose(space.to_region(300, 200), (600, 0))
    event = type("Event", (), {"mouse_x": 40 + 10, "mouse_y": 30 + 399})
    np.testing.assert_allclose(space.of_mouse(event, Region(600, 400, (0, 0, 1, 1))), (5.25, 0.25))


@pytest.mark.parametrize("second_px", [0.0, 35.0])
@pytest.mark.parametrize("name", ["CENTRE", "RIGHT", "BOTTOM", "LEFT", "TOP"])
def test_a_dragged_handle_is_where_it_was_dragged_to(in_extension, second_px, name):
    handles = in_extension("operators.outline_handles")
    outline = handles.HandOutline(100.0, 80.0, 50.0, second_px, 0.3 if second_px else 0.0)
    place = outline.handle(name)
    to = (place[0] + 7.0, place[1] - 4.0)
    moved = outline.dragged(name, to)
    if name == "CENTRE" or second_px:
        assert moved.handle(name) == pytest.approx(to)
    else:
        assert math.dist(moved.handle("CENTRE"), to) == pytest.approx(moved.radius_px)
    assert moved.round == outline.round


def test_a_photograph_is_packed_and_survives_saving(imported, tmp_path):
    assert ops.show_photograph() == {"FINISHED"}
    view = imported.views[0]
    assert tuple(view.shown.size_px) == (160, 120)
    assert view.shown.picture.packed_file is not None
    assert not imported.views[1].shown.picture
    assert ops.detect_ball() == {"FINISHED"}
    expected = (
        view.shown.summary,
        view.shown.cone_angle,
        tuple(view.found_centre_px),
        view.shown.picture.name,
    )
    pixels = view.shown.picture.pixels[:]
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))
    view = bpy.context.scene.spectral_probe.views[0]
    shown = view.shown
    assert (shown.summary, shown.cone_angle, tuple(view.found_centre_px), shown.picture.name) == expected
    assert shown.picture.pixels[:] == pixels
    assert tuple(shown.size_px) == (160, 120)


def test_a_copied_scene_does_not_replace_the_picture_of_the_first(imported):
    ops.show_photograph()
    original, picture = bpy.context.scene, imported.views[0].shown.picture
    bpy.ops.scene.new(type="FULL_COPY")
    ops.show_photograph()
    assert original.spectral_probe.views[0].shown.picture == picture
    assert bpy.context.scene.spectral_probe.views[0].shown.picture != picture


def test_showing_another_photograph_replaces_the_image_wherever_it_is_used(imported, capture_file):
    imported.views[0].photos.add().path = str(capture_file.with_name("view_1.exr"))
    ops.show_photograph(photo=1)
    before = imported.views[0].shown.picture
    assert before.name == "view_0 (1)"
    texture = bpy.data.textures.new("user", "IMAGE")
    texture.image = before
    count = len(bpy.data.images)
    ops.show_photograph(step=1)
    shown = imported.views[0].shown
    assert (shown.photo, shown.picture.name, len(bpy.data.images)) == (1, "view_0 (2)", count)
    assert texture.image == shown.picture
    ops.show_photograph(step=5)
    assert shown.photo == 1
    imported.views[0].photos[1].path = ""
    with pytest.raises(RuntimeError, match="Photograph 2 of the view has no file"):
        ops.show_photograph()


def test_an_outline_drawn_by_hand_is_what_the_capture_says(imported, in_extension, tmp_path):
    view = imported.views[0]
    edit, handles = in_extension("operators.edit_outline"), in_extension("operators.outline_handles")
    capture_from = in_extension("operators.settings").capture_from
    edit.put_outline(view, handles.HandOutline(81.0, 60.0, 49.0), snap=True)
    drawn = capture_from(imported).views[0]
    assert (drawn.outline, drawn.snap_outline) == ((81.0, 60.0, 49.0), True)
    edit.put_outline(view, handles.HandOutline(81.0, 60.0, 49.0, 45.0, math.radians(20)), snap=False)
    drawn = capture_from(imported).views[0]
    assert drawn.outline == pytest.approx((81.0, 60.0, 49.0, 45.0, 20.0))
    assert not drawn.snap_outline
    path = tmp_path / "hand.toml"
    ops.save_capture(filepath=str(path))
    saved = in_extension("spectral_probe.files.capture").load_capture(path)
    ops.import_capture(filepath=str(path))
    again = imported.views[0]
    assert saved.views[0].outline == pytest.approx(drawn.outline)
    assert (again.outline_source, round(again.outline_minor_px, 3)) == ("GIVEN", 45.0)
    assert edit.outline_of(again).angle_rad == pytest.approx(math.radians(20), abs=1e-5)


def test_detecting_near_a_circle_puts_the_handles_on_the_rim(imported, in_extension):
    view = imported.views[0]
    view.outline_source, view.outline_px, imported.all_views = "SNAP", (78.0, 61.0, 48.0), False
    assert ops.detect_ball() == {"FINISHED"}
    assert tuple(view.found_centre_px) == pytest.approx((80, 60), abs=0.7)
    assert tuple(view.outline_px) == pytest.approx(tuple(view.shown.fitted_px))
    assert not in_extension("panels.image_ball").changed_since(view)
    view.outline_px[2] += 1.0
    assert in_extension("panels.image_ball").changed_since(view)


def test_the_follower_answers_the_last_question_and_ends(imported, in_extension):
    import time

    follower_of = in_extension("operators.rim_follower").RimFollower
    capture = in_extension("operators.settings").capture_from(imported)
    follower = follower_of(capture, capture.views[0], 0)
    for x_px in (70.0, 74.0, 79.0):
        follower.ask((x_px, 60.0, 50.0), snap=True)
    follower.ask((79.0, 61.0, 50.0), snap=True, final=True)
    answers, deadline = [], time.monotonic() + 60
    while time.monotonic() < deadline and not (answers and answers[-1][1]):
        answer = follower.answer()
        answers += [answer] if answer else []
        time.sleep(0.01)
    found, final = answers[-1]
    assert (final, len(answers)) == (True, 1)
    assert found.outline.centre_px == pytest.approx((80, 60), abs=0.7)
    follower.close()


def test_only_our_photographs_have_an_outline_and_handles(imported, in_extension):
    view_shown = in_extension("operators.bridge.photograph_image").view_shown
    other = bpy.data.images.new("other", 4, 4)
    imported.active_view = 1
    ops.show_photograph()
    scene = bpy.context.scene
    assert view_shown(scene, imported.views[1].shown.picture) == 1
    assert view_shown(scene, other) is None
    assert view_shown(scene, None) is None
    assert not ops.edit_outline.poll()


def test_the_panels_draw_every_state(imported, drawn):
    panel, overlay = bpy.types.SPECTRAL_PROBE_PT_image_ball, bpy.types.SPECTRAL_PROBE_PT_image_overlay
    ops.detect_ball()
    imported.views[0].outline_source, imported.views[0].outline_minor_px = "GIVEN", 40.0
    for place in (panel, overlay):
        assert drawn(place)
    imported.views.clear()
    assert drawn(panel)
