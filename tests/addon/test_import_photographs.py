"""Photographs come in as views, whatever was dropped; they can be moved, and nothing is lost without a word."""

import math
import shutil
from pathlib import Path

import bpy
import numpy as np
import pytest

ops = bpy.ops.spectral_probe


@pytest.fixture(scope="module")
def photographs(tmp_path_factory) -> Path:
    """Two views of three exposures each as JPEG with EXIF, a minute apart; and what lies about in such folders."""
    from PIL import Image

    folder = tmp_path_factory.mktemp("photographs")
    for view in range(2):
        for shot, exposure_s in enumerate((0.001, 0.008, 0.06)):
            exif = Image.Exif()
            exif[0x10F], exif[0x110] = "Canon", "Canon EOS 5D Mark II"
            tags = exif.get_ifd(0x8769)
            tags[0x829A], tags[0x829D], tags[0x8827], tags[0x920A], tags[0xA405] = (
                exposure_s,
                8.0,
                100,
                100.0,
                100,
            )
            tags[0x9003] = f"2024:05:01 10:{view:02}:{2 * shot:02}"
            picture = Image.fromarray(np.full((60, 80, 3), 40 + 60 * shot, np.uint8))
            picture.save(folder / f"IMG_{100 + 3 * view + shot:04}.jpg", exif=exif)
    (folder / "notes.txt").write_text("f/8", encoding="utf-8")
    (folder / "clip.mp4").write_bytes(b"\0\0\0 ftypisom" + bytes(64))
    (folder / "broken.jpg").write_bytes(b"\xff\xd8\xff" + bytes(20))
    (folder / "._IMG_0100.jpg").write_bytes(b"Mac")
    return folder


def names(*files):
    return [{"name": file} for file in files]


def first(count):
    return names(*(f"IMG_{100 + number:04}.jpg" for number in range(count)))


def drop(folder, files):
    """What Blender does with files dropped where one handler takes them."""
    return ops.import_photographs(
        "INVOKE_DEFAULT", directory=f"{folder}/", files=files, filepath=str(folder / files[0]["name"])
    )


def shown(settings):
    return [
        (round(math.degrees(view.azimuth), 3), [Path(photo.path).name for photo in view.photos])
        for view in settings.views
    ]


def said(capfd):
    return capfd.readouterr().out


FIRST, SECOND = [f"IMG_{n:04}.jpg" for n in (100, 101, 102)], [f"IMG_{n:04}.jpg" for n in (103, 104, 105)]


@pytest.fixture
def two_views(settings, photographs):
    assert drop(photographs, first(6)) == {"FINISHED"}
    return settings


# ---------------------------------------------------------------- import


def test_a_drop_becomes_views(two_views, photographs):
    assert shown(two_views) == [(0.0, FIRST), (180.0, SECOND)]
    assert two_views.active_view == 0
    assert two_views.camera.model == "", "a camera's own curves apply to raw only"
    assert Path(two_views.probe_directory) == photographs / "probe"


def test_the_pipeline_takes_them_as_they_are(two_views, photographs, in_extension):
    capture = in_extension("operators.settings").capture_from(two_views)
    assert [view.azimuth_deg for view in capture.views] == [0.0, 180.0]
    assert capture.views[0].photos == tuple(photographs / name for name in FIRST)
    assert capture.views[0].exposures_s is None


def test_a_folder_stands_for_its_photographs(settings, photographs, capfd):
    assert ops.import_photographs(directory=str(photographs)) == {"FINISHED"}
    assert len(shown(settings)) == 2
    assert "broken.jpg" in said(capfd)


def test_folders_within_the_folder(settings, photographs, tmp_path):
    for view, files in (("left", FIRST), ("right", SECOND)):
        (tmp_path / view).mkdir()
        for name in files:
            shutil.copy(photographs / name, tmp_path / view)
    ops.import_photographs(directory=str(tmp_path))
    assert [files for _, files in shown(settings)] == [FIRST, SECOND]


def test_views_one_after_the_other_are_spread_again(settings, photographs):
    drop(photographs, names(*FIRST))
    drop(photographs, names(*SECOND))
    assert shown(settings) == [(0.0, FIRST), (180.0, SECOND)]
    assert settings.active_view == 1


def test_bearings_set_by_hand_stay(settings, photographs):
    drop(photographs, names(*FIRST))
    settings.views[0].azimuth = math.radians(35)
    drop(photographs, names(*SECOND))
    assert [bearing for bearing, _ in shown(settings)] == [35.0, 215.0]


def test_what_is_there_already_is_left_out_and_told(two_views, photographs, capfd):
    with pytest.raises(RuntimeError, match="All 3 photographs are in a view already"):
        drop(photographs, names(*FIRST))
    two_views.views.remove(1)
    drop(photographs, first(6))
    assert [files for _, files in shown(two_views)] == [FIRST, SECOND]
    assert "IMG_0100.jpg, IMG_0101.jpg, IMG_0102.jpg left out: in a view already" in said(capfd)


def test_replace_starts_again(two_views, photographs):
    ops.import_photographs(directory=str(photographs), files=names(*SECOND), replace=True)
    assert shown(two_views) == [(0.0, SECOND)]


def test_a_backplate_among_brackets_is_left_out_and_told(settings, photographs, capfd):
    drop(photographs, names(*FIRST, SECOND[2]))
    assert shown(settings) == [(0.0, FIRST)]
    assert f"{SECOND[2]} left out: single among brackets" in said(capfd)
    with pytest.raises(RuntimeError, match="single among brackets"):
        drop(photographs, names(*FIRST, SECOND[2]))
    drop(photographs, names(SECOND[2]))
    assert shown(settings) == [(0.0, FIRST), (180.0, SECOND[2:])]


@pytest.mark.parametrize(("views", "sizes"), [("ONE", [6]), ("EACH", [1] * 6)])
def test_sorted_as_told(settings, photographs, views, sizes):
    ops.import_photographs(directory=str(photographs), files=first(6), views=views)
    assert [len(view.photos) for view in settings.views] == sizes


@pytest.mark.usefixtures("scene")
@pytest.mark.parametrize(
    ("files", "message"),
    [
        ([], "Choose at least one photograph"),
        (["clip.mp4"], "clip.mp4 is not a photograph"),
        (["notes.txt"], "notes.txt is not a photograph"),
        (["broken.jpg"], "broken.jpg cannot be read"),
        (["elsewhere.jpg"], "no photograph .*elsewhere.jpg"),
    ],
)
def test_nothing_of_use(photographs, files, message):
    with pytest.raises(RuntimeError, match=message):
        ops.import_photographs(directory=str(photographs) if files else "", files=names(*files))
    assert not bpy.context.scene.spectral_probe.views


@pytest.mark.usefixtures("scene")
def test_an_empty_folder(tmp_path):
    with pytest.raises(RuntimeError, match="There is no photograph in"):
        ops.import_photographs(directory=str(tmp_path))


def test_good_ones_come_in_though_others_do_not(settings, photographs, capfd):
    drop(photographs, [*names("clip.mp4", "broken.jpg", "gone.jpg"), *names(*FIRST)])
    assert shown(settings) == [(0.0, FIRST)]
    told = said(capfd)
    for name in ("clip.mp4", "broken.jpg", "gone.jpg"):
        assert f"Warning: {name}" in told or f"{name}. " in told, told


def test_photographs_that_say_nothing(settings, tmp_path, capfd):
    from PIL import Image

    for name, grey in (("north.jpg", 100), ("south.jpg", 103)):
        Image.fromarray(np.full((60, 80, 3), grey, np.uint8)).save(tmp_path / name)
    ops.import_photographs(directory=str(tmp_path))
    assert [view.photos[0].exposure_s for view in settings.views] == [1.0, 1.0]
    assert "taken to be exposed alike" in said(capfd)


# ---------------------------------------------------------------- capture files


def test_a_capture_file_among_the_photographs_goes_before(settings, capture_file, capfd):
    shutil.copy(capture_file.parent / "view_0.exr", capture_file.parent / "other.exr")
    drop(capture_file.parent, names("view_0.exr", "capture.toml", "view_1.exr", "other.exr"))
    assert settings.capture_path == str(capture_file)
    assert [bearing for bearing, _ in shown(settings)] == [0.0, 120.0]
    assert "other.exr left out: the capture file does not name them" in said(capfd)


def test_a_capture_file_alone_may_be_dropped(settings, capture_file):
    drop(capture_file.parent, names("capture.toml"))
    assert len(settings.views) == 2


def test_a_capture_file_beside_exactly_these_photographs_is_used(settings, capture_file):
    drop(capture_file.parent, names("view_0.exr", "view_1.exr"))
    assert settings.capture_path == str(capture_file)
    ops.import_photographs(
        directory=str(capture_file.parent),
        files=names("view_0.exr", "view_1.exr"),
        replace=True,
        use_capture_file=False,
    )
    assert [bearing for bearing, _ in shown(settings)] == [0.0, 180.0]


def test_a_part_of_what_a_capture_file_names_is_not_that_capture(settings, capture_file):
    drop(capture_file.parent, names("view_0.exr"))
    assert settings.capture_path == ""
    assert len(settings.views) == 1


@pytest.mark.usefixtures("scene")
def test_two_capture_files(capture_file):
    shutil.copy(capture_file, capture_file.with_name("copy.toml"))
    with pytest.raises(RuntimeError, match="2 capture files"):
        drop(capture_file.parent, names("capture.toml", "copy.toml"))


def test_raw_photographs_choose_their_camera(settings, project_root):
    gym = project_root / "sample_scenes" / "gym"
    ops.import_photographs(directory=str(gym), files=names("view0_0.dng", "view0_1.dng"))
    assert settings.camera.model == "Nikon 5100 (NPL)"
    assert shown(settings) == [(0.0, ["view0_0.dng", "view0_1.dng"])]


def test_a_sensor_is_assumed_and_told_where_nothing_says_it(settings, project_root, capfd):
    gym = project_root / "sample_scenes" / "gym"
    ops.import_photographs(directory=str(gym), files=names("view0_0.dng", "view0_1.dng"))
    assert settings.camera.focal_source == "EXIF", "the focal length is said"
    assert settings.camera.sensor_width_mm == 36.0
    told = said(capfd)
    assert "Warning: The photographs do not say how wide the sensor is: 36 mm" in told
    settings.camera.sensor_width_mm = 23.5
    ops.import_photographs(directory=str(gym), files=names("view1_0.dng", "view1_1.dng"))
    assert settings.camera.sensor_width_mm == 23.5, "what the user gave stays"
    assert "how wide" not in said(capfd)


def test_a_lens_is_assumed_and_told_where_nothing_says_it(settings, tmp_path, capfd):
    from PIL import Image

    Image.fromarray(np.full((60, 80, 3), 100, np.uint8)).save(tmp_path / "ball.jpg")
    ops.import_photographs(directory=str(tmp_path))
    camera = settings.camera
    assert (camera.focal_source, camera.focal_mm, camera.sensor_width_mm) == ("MM", 50.0, 36.0)
    assert "50 mm on a sensor 36 mm wide is assumed" in said(capfd)


def test_a_telephones_sensor_is_small(settings, in_extension):
    grouping, metadata = (in_extension(f"spectral_probe.photo.{name}") for name in ("grouping", "metadata"))
    views = in_extension("operators.photograph_views")
    group = grouping.ViewGroup((metadata.PhotoRecord(Path("IMG_1.jpg"), focal_mm=4.5),))
    assert "6 mm is assumed" in views.assume_lens(settings, [group])[0]
    assert settings.camera.sensor_width_mm == 6.0, "as wide a view as 27 mm on full frame"


def _record(name, size_px=(60, 40), exposure=True, taken_s=None, in_extension=None):
    metadata, model = in_extension("spectral_probe.photo.metadata"), in_extension("spectral_probe.model")
    return metadata.PhotoRecord(
        Path(name), size_px=size_px, exposure=model.Exposure(0.01) if exposure else None, taken_s=taken_s
    )


def test_cut_and_unexposed_photographs_are_left_out_and_told(in_extension):
    grouping, choice = (
        in_extension("spectral_probe.photo.grouping"),
        in_extension("operators.photograph_choice"),
    )

    def group(prefix, **words):
        times_s = [10.0 * number for number in range(3)] if words.pop("timed") else [None] * 3
        return grouping.ViewGroup(
            tuple(
                _record(f"{prefix}{number}.jpg", taken_s=taken_s, in_extension=in_extension, **words)
                for number, taken_s in enumerate(times_s)
            )
        )

    cut, whole = group("cut", timed=True, size_px=(30, 30)), group("whole", timed=True)
    other = group("edited", timed=False, exposure=False)
    kept, told = choice.of_the_ball([cut, whole, other])
    assert kept == [whole]
    assert "cut0.jpg, cut1.jpg, cut2.jpg left out: the same photographs, smaller or cut" in told[0]
    assert "edited0.jpg, edited1.jpg, edited2.jpg left out: no exposure times" in told[1]
    assert choice.of_the_ball([other]) == ([other], [])


# ---------------------------------------------------------------- where they may be dropped


def test_the_file_handler_is_there_where_it_should_be(in_extension):
    handler = bpy.types.FileHandler.bl_rna_get_subclass_py("SPECTRAL_PROBE_FH_photographs")
    assert handler.bl_import_operator == "spectral_probe.import_photographs"
    known = in_extension("spectral_probe.photo.suffixes").PHOTOGRAPHS
    assert set(handler.bl_file_extensions.split(";")) == {".toml", *known}
    window = bpy.context.window_manager.windows[0]
    for area in window.screen.areas:
        kind = area.type
        for place in ("VIEW_3D", "IMAGE_EDITOR", "PROPERTIES", "TEXT_EDITOR", "SEQUENCE_EDITOR"):
            area.type = place
            with bpy.context.temp_override(window=window, area=area):
                assert handler.poll_drop(bpy.context) == (place in {"VIEW_3D", "IMAGE_EDITOR", "PROPERTIES"})
        area.type = kind
        break


def test_the_browser_pattern_fits_into_blenders_field(in_extension):
    assert len(in_extension("operators.photograph_files").BROWSED) < 256


def test_the_menu_has_one_line_and_loses_it(extension):
    functions = bpy.types.TOPBAR_MT_file_import._dyn_ui_initialize()
    ours = [function for function in functions if function.__module__.startswith(extension.__name__)]
    assert len(ours) == 1
    extension.unregister()
    try:
        assert ours[0] not in functions
    finally:
        extension.register()


# ---------------------------------------------------------------- moved by hand


def test_move_to_another_view_and_back(two_views):
    two_views.views[0].photos[1].exposure_s = 0.5
    two_views.views[0].active_photo = 1
    ops.move_photo(view=2)
    assert [files for _, files in shown(two_views)] == [[FIRST[0], FIRST[2]], [*SECOND, FIRST[1]]]
    assert two_views.active_view == 1
    view = two_views.views[1]
    assert (view.active_photo, view.photos[3].exposure_s) == (3, 0.5)
    ops.move_photo(view=1)
    assert [sorted(files) for _, files in shown(two_views)] == [FIRST, SECOND]


def test_move_to_a_new_view(two_views):
    two_views.views[0].active_photo = 1
    ops.move_photo(view=0, following=True)
    assert shown(two_views) == [(0.0, FIRST[:1]), (120.0, FIRST[1:]), (240.0, SECOND)]
    assert two_views.views[1].name == "IMG_0101"


def test_a_view_that_lost_its_last_photograph_goes(two_views):
    ops.move_photo(view=2, following=True)
    assert [files for _, files in shown(two_views)] == [[*SECOND, *FIRST]]
    assert two_views.active_view == 0
    for _ in range(6):
        ops.remove_photo()
    assert not two_views.views
    assert not ops.remove_photo.poll()
    assert not ops.move_photo.poll()


def test_move_to_a_view_that_is_not_there(two_views):
    with pytest.raises(RuntimeError, match="no view 7"):
        ops.move_photo(view=7)
    assert len(two_views.views) == 2


def test_join_views(two_views):
    with pytest.raises(RuntimeError, match="no view there"):
        ops.join_views(other="BEFORE")
    ops.join_views(other="AFTER")
    assert [files for _, files in shown(two_views)] == [[*FIRST, *SECOND]]
    assert not ops.join_views.poll()


def test_add_photographs_to_a_view(settings, photographs):
    assert not ops.add_photos.poll()
    drop(photographs, names(*FIRST[:2]))
    with pytest.raises(RuntimeError, match="is not a photograph"):
        ops.add_photos(directory=str(photographs), files=names(FIRST[2], "notes.txt"))
    ops.add_photos(directory=str(photographs), files=names(*FIRST))
    assert [files for _, files in shown(settings)] == [FIRST]
    with pytest.raises(RuntimeError, match="in a view already"):
        ops.add_photos(directory=str(photographs), files=names(*FIRST))


def test_spread_views(two_views):
    ops.move_photo(view=0)
    ops.spread_views(first=math.radians(10), clockwise=False)
    assert [bearing for bearing, _ in shown(two_views)] == [10.0, 250.0, 130.0]
