"""What a capture file says of the light: filters, own lights, regions and calibration."""

import re
import tomllib
from pathlib import Path

import pytest

from spectral_probe.errors import CaptureError
from spectral_probe.files.capture import load_capture, save_capture
from spectral_probe.light_settings import CalibrationSettings, Region, RegionLight

GOOD = """
[light]
method = "automatic"
families = ["incandescent"]
spectra = ["lamp.csv", "other.csv"]

[calibration]
patch_px = [10, 20, 30.5, 40]
view = 2
spectrum = "lamp.csv"
reflectance = "card.csv"
absolute = true
ball_patch_px = [50, 60, 70, 80]

[[view]]
photos = ["a.dng"]

[[view]]
photos = ["b.dng"]
filter = "green.csv"

[[view]]
photos = ["b.dng"]
filter = "yellow"

[[region]]
polygon_deg = [[10, 5], [40, 5.5], [25, 30]]
families = ["fluorescent-triband"]

[[region]]
mask = "mask.png"
spectrum = "lamp.csv"

[[region]]
seed_deg = [-120, 10]
families = "daylight"
"""


@pytest.fixture
def write(tmp_path):
    for name in ("a.dng", "b.dng", "lamp.csv", "other.csv", "card.csv", "green.csv", "mask.png"):
        (tmp_path / name).touch()

    def write(text):
        path = tmp_path / "capture.toml"
        path.write_text(text)
        return path

    return write


def test_everything_is_read(write, tmp_path):
    capture = load_capture(write(GOOD))
    assert (capture.method, capture.families) == ("automatic", ("incandescent",))
    assert capture.spectra == (tmp_path / "lamp.csv", tmp_path / "other.csv")
    assert [view.filter for view in capture.views] == [None, tmp_path / "green.csv", "yellow"]
    assert capture.regions == (
        RegionLight(
            Region(polygon_deg=((10.0, 5.0), (40.0, 5.5), (25.0, 30.0))), families=("fluorescent-triband",)
        ),
        RegionLight(Region(mask=tmp_path / "mask.png"), spectrum=tmp_path / "lamp.csv"),
        RegionLight(Region(seed_deg=(-120.0, 10.0)), families=("daylight",)),
    )
    assert capture.calibration == CalibrationSettings(
        patch_px=(10.0, 20.0, 30.5, 40.0), view=2, spectrum=tmp_path / "lamp.csv", reflectance=tmp_path / "card.csv",
        absolute=True, ball_patch_px=(50.0, 60.0, 70.0, 80.0),
    )  # fmt: skip


def test_saving_and_loading_again_gives_the_same(write, tmp_path):
    capture = load_capture(write(GOOD))
    save_capture(capture, tmp_path / "again.toml")
    assert load_capture(tmp_path / "again.toml") == capture
    assert str(tmp_path) not in (tmp_path / "again.toml").read_text()  # paths are relative


def test_a_lamp_in_the_ball_is_kept_too(write, tmp_path):
    text = '[calibration]\nlight_at = [45, 30]\nilluminant = "A"\n\n[[view]]\nphotos = ["a.dng"]\n'
    capture = load_capture(write(text))
    assert capture.calibration == CalibrationSettings(light_at=(45.0, 30.0), illuminant="A")
    save_capture(capture, tmp_path / "again.toml")
    assert load_capture(tmp_path / "again.toml") == capture


def test_without_these_keys_nothing_is_claimed(write):
    capture = load_capture(write('[[view]]\nphotos = ["a.dng"]'))
    assert (capture.spectra, capture.regions, capture.calibration) == ((), (), None)
    assert capture.views[0].filter is None


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("spectra =", "spectrums =", r'\[light\]: there is no key "spectrums"\. Did you mean "spectra"'),
        ('"other.csv"]', "7]", "spectra must be a list of files"),
        ('"other.csv"]', '"none.csv"]', r"there is no file .*none\.csv"),
        ("filter =", "filtre =", r'there is no key "filtre"\. Did you mean "filter"'),
        ('filter = "green.csv"', "filter = 3", "filter must be text"),
        ('"green.csv"', '"gone.csv"', r"\[\[view\]\] 2: there is no file .*gone\.csv"),
        ("[[region]]\nmask", "[[region]]\nmaske", r'\[\[region\]\] 2: there is no key "maske"'),
        ("[[region]]\nmask", "[[region]]\nseed_deg = [1, 2]\nmask", "needs one of polygon_deg, mask and seed_deg"),
        ('mask = "mask.png"\n', "", "needs one of polygon_deg, mask and seed_deg"),
        (', [25, 30]]', "]", "three corners or more"),
        ("[40, 5.5]", "[40]", "a list of pairs of numbers"),
        ('families = "daylight"', "", "either families or a measured spectrum"),
        ('families = "daylight"', 'families = "daylight"\nspectrum = "lamp.csv"', "not both"),
        ("patch_px = [10", "light_at = [1, 2]\npatch_px = [10", "either light_at .* or patch_px"),
        ("patch_px = [10, 20, 30.5, 40]\n", "", "either light_at .* or patch_px"),
        ("[10, 20, 30.5, 40]", "[10, 20, 30.5]", "patch_px must be a list of 4 numbers"),
        ("[10, 20, 30.5, 40]", "[30.5, 20, 10, 40]", "x0 < x1"),
        ("[10, 20, 30.5, 40]\n", '[10, 20, 30.5, 40]\nilluminant = "A"\n', "either spectrum .* or illuminant"),
        ('view = 2\nspectrum = "lamp.csv"', 'illuminant = "A"', "absolute = true needs a spectrum measured in W"),
        ('reflectance = "card.csv"', "reflectance = 18", "reflectance lies above 0 and up to 1 .* not at 18"),
        ('reflectance = "card.csv"', "reflectance = []", "reflectance must be a number"),
        ("view = 2", "view = 0", "view must be the number of a view"),
        ("patch_px = [10, 20, 30.5, 40]", "light_at = [1, 2]", "Give patch_px as well"),
    ],
)  # fmt: skip
def test_mistakes_are_named(write, old, new, message):
    assert old in GOOD
    with pytest.raises(CaptureError, match=message) as caught:
        load_capture(write(GOOD.replace(old, new, 1)))
    assert "\n" not in str(caught.value)


def test_single_brackets_are_named(write):
    with pytest.raises(CaptureError, match=r"Write \[\[region\]\] for each region"):
        load_capture(write('[[view]]\nphotos = ["a.dng"]\n\n[region]\nseed_deg = [1, 2]\n'))


def test_an_elevation_beyond_the_zenith_is_named():
    with pytest.raises(CaptureError, match="between -90 and 90"):
        CalibrationSettings(light_at=(0.0, 95.0), illuminant="A").check()


def test_a_glass_is_a_name_and_a_file_a_path(write):
    views = load_capture(write(GOOD)).views
    assert isinstance(views[1].filter, Path)
    assert isinstance(views[2].filter, str)


def test_the_page_on_capture_files_is_whole_and_true(project_root):
    """Every key is on the page, and what the page writes is TOML with known keys."""
    from spectral_probe.files import capture, capture_light

    page = (project_root / "docs" / "capture.md").read_text()
    blocks = [tomllib.loads(block) for block in re.findall(r"```toml\n(.*?)```", page, flags=re.DOTALL)]
    known = {
        "camera": capture._CAMERA_KEYS,
        "ball": capture._BALL_KEYS,
        "light": capture._LIGHT_KEYS,
        "panorama": capture._PANORAMA_KEYS,
        "view": capture._VIEW_KEYS,
        "region": capture_light._REGION_KEYS,
        "calibration": capture_light._CALIBRATION_KEYS,
    }
    for block in blocks:
        assert set(block) <= set(known)
        for name, table in block.items():
            written = set(table[0] if isinstance(table, list) else table)
            assert written <= set(known[name])
    for keys in known.values():
        missing = [key for key in keys if not re.search(rf"^(# )?{key} = ", page, flags=re.MULTILINE)]
        assert missing == []
