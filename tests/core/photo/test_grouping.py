"""Brackets and views are told by exposure, time and names; no photograph is lost."""

from dataclasses import replace
from pathlib import Path

import pytest

from spectral_probe.errors import PhotographError
from spectral_probe.model import Exposure
from spectral_probe.photo.grouping import group_photographs
from spectral_probe.photo.metadata import PhotoRecord, read_record

CAMERA = PhotoRecord(
    Path(), "raw", (6000, 4000), camera="Canon EOS R5", lens="RF 100mm", focal_mm=100.0, f_number=8.0
)


def taken(*shots, folder="/photos", names="IMG_{:04}.CR3", **changes):
    """Photographs of one camera, each (seconds since the first, exposure in seconds)."""
    return [
        replace(
            CAMERA,
            path=Path(folder) / names.format(number),
            taken_s=at,
            exposure=Exposure(exposure_s, 100.0, 8.0),
            **changes,
        )
        for number, (at, exposure_s) in enumerate(shots)
    ]


def exposures(records, order="given"):
    """Exposure times of each view, photographs given in any order."""
    records = list(records)
    if order == "mixed":
        records = records[::-2] + records[::2] + records  # some twice
    grouping = group_photographs(records)
    grouped = sorted(photo.path for view in grouping.views for photo in view.photos)
    assert grouped == sorted({record.path for record in records}), "a photograph was lost, or is in two views"
    return [tuple(photo.exposure.time_s for photo in view.photos) for view in grouping.views]


ROW = (1 / 1000, 1 / 125, 1 / 15)


@pytest.mark.parametrize("order", ["given", "mixed"])
def test_three_views_of_a_rising_row(order):
    shots = [(60.0 * view + 2 * i, s) for view in range(3) for i, s in enumerate(ROW)]
    assert exposures(taken(*shots), order) == [ROW, ROW, ROW]


@pytest.mark.parametrize(
    "row", [(1, 0.25, 4), (1, 0.5, 2, 0.25, 4), (1, 0.25, 0.5, 2, 4), (1, 0.5, 0.25, 2, 4)]
)
def test_automatic_bracketing_starts_in_the_middle(row):
    row = tuple(s / 100 for s in row)
    shots = [(20.0 * view + 0.3 * i, s) for view in range(4) for i, s in enumerate(row)]
    assert exposures(taken(*shots), "mixed") == [row] * 4


def test_without_dates_the_order_of_names_counts():
    records = [replace(record, taken_s=None) for record in taken(*((0, s) for _ in range(3) for s in ROW))]
    assert exposures(records, "mixed") == [ROW] * 3


def test_a_row_that_starts_again_with_other_exposures():
    other = tuple(s * 1.25 for s in ROW)
    shots = [(8.0 * i, s) for i, s in enumerate((*ROW, *other))]
    assert exposures(taken(*shots)) == [ROW, other]


def test_an_exposure_beyond_the_ends_widens_the_row():
    row = (1 / 100, 1 / 200, 1 / 400, 1 / 50, 1 / 25)
    assert exposures(taken(*((5.0 * i, s) for i, s in enumerate(row)))) == [row]


def test_steps_of_a_third_do_not_end_a_row():
    row = (1 / 160, 1 / 250, 1 / 320, 1 / 640)
    assert exposures(taken(*((6.0 * i, s) for i, s in enumerate(row)))) == [row]


def test_a_pause_begins_a_view():
    shots = [(0, 1 / 100), (1, 1 / 25), (30, 1 / 400), (31, 1 / 1600)]
    assert exposures(taken(*shots)) == [(1 / 100, 1 / 25), (1 / 400, 1 / 1600)]


def test_long_exposures_are_no_pause():
    row = (1.0, 15.0, 120.0)
    assert exposures(taken((0, 1.0), (3, 15.0), (20, 120.0))) == [row]


def test_missing_numbers_begin_a_view_where_there_are_no_dates():
    records = [
        replace(record, taken_s=None)
        for record in taken((0, 1 / 100), (0, 1 / 25), (0, 1 / 400), (0, 1 / 1600))
    ]
    records[2:] = [
        replace(record, path=Path(f"/photos/IMG_{90 + i:04}.CR3")) for i, record in enumerate(records[2:])
    ]
    assert exposures(records) == [(1 / 100, 1 / 25), (1 / 400, 1 / 1600)]


def test_a_backplate_taken_apart_stands_alone():
    shots = [(0, 1 / 30), (97, 1 / 90), (129, 1 / 60), (139, 1 / 30), (148, 1 / 8)]
    assert exposures(taken(*shots)) == [(1 / 90, 1 / 60, 1 / 30, 1 / 8), (1 / 30,)]


def test_views_of_one_photograph_each():
    assert exposures(taken(*((10.0 * i, 1 / 50) for i in range(20)))) == [(1 / 50,)] * 20
    metered = (1 / 60, 1 / 80, 1 / 50)
    assert exposures(taken(*((10.0 * i, s) for i, s in enumerate(metered)))) == [(s,) for s in metered]


def test_only_iso_changes():
    records = [
        replace(record, exposure=Exposure(1 / 50, iso, 8.0))
        for record, iso in zip(taken(*((i, 0) for i in range(4))), (100, 1600, 100, 1600), strict=True)
    ]
    assert [len(view) for view in exposures(records)] == [2, 2]


@pytest.mark.parametrize(
    "change",
    [
        {"camera": "SONY ILCE-6000"}, {"lens": "EF 50mm"}, {"focal_mm": 50.0}, {"f_number": 16.0}, {"encoding": "converted"},
        {"size_px": (4000, 6000)}, {"size_px": (1500, 1000)}, {"path": Path("/elsewhere/IMG_0001.CR3")},
    ],
    ids=lambda change: next(iter(change)),
)  # fmt: skip
def test_what_does_not_change_within_a_bracket(change):
    first, second = taken((0, 1 / 100), (1, 1 / 10))
    assert len(exposures([first, second])) == 1
    assert len(exposures([first, replace(second, **change)])) == 2


def test_sizes_cut_by_hand_are_one_bracket():
    records = [
        replace(r, size_px=size)
        for r, size in zip(taken((0, 0.1), (1, 0.01)), [(1486, 1448), (1472, 1428)], strict=True)
    ]
    assert len(exposures(records)) == 1


def test_names_that_state_the_view_go_before_exposures():
    records = [
        record
        for view in range(2)
        for record in taken((0, 0.1), (1, 0.1), (2, 0.01), names=f"v{view}-{{}}.cr3")
    ]
    assert [[photo.name[:2] for photo in view.photos] for view in group_photographs(records).views] == [
        ["v0"] * 3,
        ["v1"] * 3,
    ]
    versions = taken((0, 0.1), (1, 0.01), (2, 0.1), (3, 0.01), names="IMG_{:04}_v2.tif")
    assert [len(view) for view in exposures(versions)] == [2, 2], "a version number is no view"


def test_one_given_twice_counts_once():
    assert exposures([*taken((0, 0.1), (1, 0.01)), *taken((0, 0.1))]) == [(0.1, 0.01)]


def test_pictures_beside_their_raw_files_are_left_out_and_told():
    raw = taken((0, 0.1), (1, 0.01))
    pairs = [replace(record, path=record.path.with_suffix(".JPG"), encoding="converted") for record in raw]
    alone = replace(pairs[0], path=Path("/photos/IMG_0009.JPG"), taken_s=900.0)
    grouping = group_photographs([*pairs, alone, *raw])
    assert [len(view.photos) for view in grouping.views] == [2, 1]
    assert grouping.beside_raw == tuple(pairs)


def test_nothing_gives_nothing():
    assert group_photographs([]).views == ()


# ---------------------------------------------------------------- files that say no exposure


def unstated(names, brightness):
    return [
        PhotoRecord(Path("/photos") / name, size_px=(800, 600), brightness=b)
        for name, b in zip(names, brightness, strict=True)
    ]


@pytest.mark.parametrize(
    ("names", "brightness", "expected"),
    [
        (("Ball10.jpg", "Ball40.jpg", "Ball180.jpg"), (0.8, 0.5, 0.3), [3]),
        (("a_1.jpg", "a_2.jpg", "b_1.jpg", "b_2.jpg"), (0.8, 0.3, 0.8, 0.3), [2, 2]),
        (("set0_1.jpg", "set0_2.jpg", "set1_1.jpg", "set1_2.jpg"), (0.8, 0.3, 0.8, 0.3), [2, 2]),
        (("north.jpg", "east.jpg", "south.jpg"), (0.5, 0.52, 0.48), [1, 1, 1]),
        (("dark.jpg", "middle.jpg", "bright.jpg"), (0.1, 0.4, 0.8), [3]),
        (("view0_0.jpg", "view0_1.jpg", "view1_0.jpg"), (0.5, 0.5, 0.5), [2, 1]),
        (("view0.jpg", "view1.jpg"), (0.1, 0.8), [1, 1]),
        (("broken1.jpg", "broken2.jpg"), (None, None), [2]),
    ],
)
def test_names_and_brightness_stand_in(names, brightness, expected):
    grouping = group_photographs(unstated(names, brightness))
    assert [len(view.photos) for view in grouping.views] == expected
    assert all("no exposure" in view.hints for view in grouping.views)


def test_merged_radiance_is_a_view_a_file():
    records = [PhotoRecord(Path(f"/photos/ball_{i}.hdr"), "radiance") for i in range(3)]
    grouping = group_photographs(records)
    assert [len(view.photos) for view in grouping.views] == [1, 1, 1]
    assert all(not view.hints for view in grouping.views)


# ---------------------------------------------------------------- what is said


def test_hints():
    views = [
        record
        for view in range(3)
        for record in taken(
            *((60 * view + 2 * i, s) for i, s in enumerate(ROW)), names=f"view{view}_{{}}.cr3"
        )
    ]
    grouping = group_photographs([*views[:-1], *taken((900, 0.1), names="plate{}.cr3")])
    assert [view.hints for view in grouping.views][-1] == ("one photograph",)
    assert sorted(view.hints for view in grouping.views)[-1] == ("uneven",)
    small = [
        replace(record, path=record.path.with_name(f"small_{record.name}"), size_px=(600, 400))
        for record in views[:3]
    ]
    assert all(view.hints == ("same moment",) for view in group_photographs([*views[:3], *small]).views)
    assert group_photographs([*views[:3], replace(views[3], camera="Phone")]).cameras == (
        "Canon EOS R5",
        "Phone",
    )


# ---------------------------------------------------------------- real photographs


def read_all(folder, pattern="*"):
    records = []
    for path in sorted(folder.glob(pattern)):
        try:
            records.append(read_record(path))
        except PhotographError:
            continue
    return [[photo.name for photo in view.photos] for view in group_photographs(records).views]


def test_the_gym_without_its_capture_file(project_root):
    views = read_all(project_root / "sample_scenes" / "gym", "*.dng")
    assert views == [[f"view{view}_{i}.dng" for i in range(3)] for view in range(3)]


def test_real_brackets(shared_dir):
    photos = shared_dir / "photos"
    assert read_all(shared_dir / "captures" / "gym") == [
        [f"view{v}_{i}.dng" for i in range(5)] for v in range(3)
    ]
    living_room = [["raw2.jpg", "raw1.jpg", "raw3.jpg"], ["raw0.jpg"]]
    assert read_all(photos / "bracket_a6400_livingroom", "raw*") == living_room
    times = (20, 40, 80, 160, 250, 320, 640, 1250, 2000, 3200, 4000)
    office = [[f"cp_t{t}.jpg" for t in times], [f"t{t}.JPG" for t in (20, 80, 320, 4000)], ["empty.jpg"]]
    assert read_all(photos / "bracket_a6000_office") == office
    library = read_all(photos / "bracket_motog_library")
    ball = ["graingerBall_1_90", "graingerBall_1_60", "graingerBall_1_30", "graingerBall_1_8"]
    copies, cut = [f"{name} copy.jpg" for name in ball], [f"{name}.jpg" for name in ball]
    assert library == [copies, cut, ["graingerBall_background.jpg"], ["graingerBall_1_125.jpg"]]
    lobby = read_all(photos / "multiview_mirrorball_lobby", "LRM*")
    assert len(lobby) == 20
    assert {len(view) for view in lobby} == {1}
    assert read_all(photos / "bad_bracket_duplicate") == [["Ball10.jpg", "Ball40.jpg", "Ball180.jpg"]]
