from dataclasses import replace

import pytest

from spectral_probe.errors import CaptureError
from spectral_probe.files.capture import load_capture, save_capture

GOOD = """
[camera]
model = "Nikon 5100 (NPL)"
focal_px = 5720.3
principal_px = [400.0, 400.0]

[ball]
radius_m = 0.05
material = { Fe = 0.74, Cr = 0.18, Ni = 0.08 }

[light]
families = ["incandescent", "daylight"]

[[view]]
azimuth_deg = 120
elevation_deg = 5
photos = ["a.dng", "b.dng"]
exposures_s = [0.0005, 0.004]
iso = 200
outline = [400, 400, 358]
"""


@pytest.fixture
def write(tmp_path):
    for name in ("a.dng", "b.dng"):
        (tmp_path / name).touch()

    def write(text):
        path = tmp_path / "capture.toml"
        path.write_text(text)
        return path

    return write


def test_everything_is_read(write, tmp_path):
    capture = load_capture(write(GOOD))
    view = capture.views[0]
    assert capture.camera.focal_px == (5720.3, 5720.3)
    assert capture.ball.material == {"Fe": 0.74, "Cr": 0.18, "Ni": 0.08}
    assert view.photos == (tmp_path / "a.dng", tmp_path / "b.dng")
    assert (view.azimuth_deg, view.elevation_deg, view.refine) == (120.0, 5.0, True)
    assert view.exposures_s == (0.0005, 0.004)
    assert view.iso == (200.0, 200.0)
    assert view.f_number is None
    assert view.outline == (400.0, 400.0, 358.0)


def test_defaults(write):
    capture = load_capture(write('[[view]]\nphotos = ["a.dng"]'))
    assert capture.families == ("incandescent", "daylight")
    assert capture.ball.radius_m == 0.05
    assert capture.camera.model is None


def test_saving_and_loading_again_gives_the_same(write, tmp_path):
    capture = load_capture(write(GOOD))
    odd = replace(
        capture.camera,
        model='A "quoted" \\ name',
        focal_px=None,
        focal_mm=35.0,
        distortion=(0.1, 0, 0, 0, 0.0),
    )
    capture = replace(capture, camera=odd, method="paper")
    save_capture(capture, tmp_path / "again.toml")
    assert load_capture(tmp_path / "again.toml") == capture


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("focal_px", "focal_pxx", r'there is no key "focal_pxx"\. Did you mean "focal_px"\?'),
        ("[ball]", "[bal]", r'there is no key "bal"\. Did you mean "ball"\?'),
        (
            "azimuth_deg = 120",
            "azimut = 120",
            r'\[\[view\]\] 1: there is no key "azimut"\. Did you mean "azimuth_deg"',
        ),
        ("radius_m = 0.05", "radius_m = 0.05.1", r"capture\.toml is not valid TOML: .*line 8"),
        ("radius_m = 0.05", 'radius_m = "5 cm"', "radius_m must be a positive number"),
        ("azimuth_deg = 120", "azimuth_deg = nan", "azimuth_deg must be a number"),
        ("elevation_deg = 5", "elevation_deg = 120", "elevation_deg must be between -90 and 90"),
        ("radius_m = 0.05", "radius_m = -1", "radius_m must be a positive number"),
        ("5720.3", "[1, 2, 3]", "focal_px must be a list of 2 numbers"),
        ('"b.dng"', '"c.dng"', r"there is no file .*c\.dng"),
        ("[0.0005, 0.004]", "[0.0005]", "exposures_s must be a list of 2 numbers"),
        ("[0.0005, 0.004]", "[0.0005, 0]", "exposures_s must be a list of positive numbers"),
        ("[400, 400, 358]", "[400, 400]", "outline must be a list of 3 or 5 numbers"),
        ("[400, 400, 358]", "[400, 400, 0]", "positive radius"),
        ("[[view]]", "[view]", r"Write \[\[view\]\] for each view"),
        ('["a.dng", "b.dng"]', "[]", "photos must be a list of file names"),
        (
            "{ Fe = 0.74, Cr = 0.18, Ni = 0.08 }",
            "{ Fe = -1 }",
            "material must be a name, or positive fractions",
        ),
        ('["incandescent", "daylight"]', "[]", "families must be a list of lamp families"),
        ("[light]", "[light]\nmethod = 3", "method must be text"),
    ],
)
def test_mistakes_are_named(write, old, new, message):
    assert old in GOOD
    with pytest.raises(CaptureError, match=message) as caught:
        load_capture(write(GOOD.replace(old, new)))
    assert "\n" not in str(caught.value)


def test_no_view(write):
    with pytest.raises(CaptureError, match=r"has no view\. Add a \[\[view\]\]"):
        load_capture(write(GOOD.split("[[view]]", maxsplit=1)[0]))
    with pytest.raises(CaptureError, match="has no view"):
        load_capture(write("view = []"))


def test_no_file(tmp_path):
    with pytest.raises(CaptureError, match="There is no capture file"):
        load_capture(tmp_path / "none.toml")
    with pytest.raises(CaptureError, match="cannot be read"):
        load_capture(tmp_path)


def test_keys_of_the_capture_and_its_geometry(write, tmp_path):
    text = GOOD.replace("[light]", '[panorama]\ncomposition = "cut"\n\n[light]').replace(
        "[ball]", "half_size = true\n\n[ball]"
    )
    capture = load_capture(write(text + "ball_at = [390, 410]\nsolve_exposures = false\n"))
    view = capture.views[0]
    assert (capture.composition, capture.camera.half_size) == ("cut", True)
    assert (view.ball_at, view.solve_exposures) == ((390.0, 410.0), False)
    save_capture(capture, tmp_path / "again.toml")
    assert load_capture(tmp_path / "again.toml") == capture


def test_an_unknown_composition_is_refused(write):
    with pytest.raises(CaptureError, match='composition must be "blend" or "cut"'):
        load_capture(write('[panorama]\ncomposition = "mosaic"\n' + GOOD))


def test_a_measured_ball_and_a_folder_of_cameras_are_relative_to_the_capture_file(write, tmp_path):
    (tmp_path / "lists").mkdir()
    (tmp_path / "lists" / "my ball.csv").write_text("400,0.5\n")
    text = GOOD.replace("{ Fe = 0.74, Cr = 0.18, Ni = 0.08 }", '"lists/my ball.csv"')
    capture = load_capture(write(text.replace("focal_px", 'sensitivities = "lists"\nfocal_px')))
    assert capture.ball.material == str(tmp_path / "lists" / "my ball.csv")
    assert capture.camera.sensitivities == tmp_path / "lists"
    save_capture(capture, tmp_path / "again.toml")
    assert 'material = "lists/my ball.csv"' in (tmp_path / "again.toml").read_text()
    assert load_capture(tmp_path / "again.toml") == capture
    with pytest.raises(CaptureError, match=r"\[ball\]: there is no file .*other\.csv"):
        load_capture(write(text.replace("my ball", "other")))
