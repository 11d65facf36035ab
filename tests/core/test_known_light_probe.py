"""Filters, own lamps, regions and calibration change the probe as they should, in a simulated room."""

from dataclasses import replace

import numpy as np
import pytest

from spectral_probe.errors import SpectralProbeError
from spectral_probe.geometry.frames import bearing_to_direction, direction_to_equirectangular
from spectral_probe.light_settings import CalibrationSettings, Region, RegionLight
from spectral_probe.model import BallSettings, Capture, ViewSettings, finish
from spectral_probe.probe import build_probe
from spectral_probe.spectra.colorimetry import illuminant
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.metals import ball_reflectance

WIDTH = 128
ROUND_THE_TUBE = ((45.0, 22.0), (78.0, 22.0), (85.0, 50.0), (38.0, 50.0))


@pytest.fixture(scope="module")
def folder(tmp_path_factory, three_lamps, green_filter):
    """Photographs of the room, and spectra as files."""
    folder = tmp_path_factory.mktemp("room")
    three_lamps.write(folder / "plain.exr")
    three_lamps.write(folder / "green.exr", transmittance=green_filter, seed=1)
    for name, values in {
        "green": green_filter,
        "tube": illuminant("FL11"),
        "A": 2.0 * illuminant("A"),
    }.items():
        save(folder / f"{name}.csv", values)
    return folder


def save(path, values):
    path.write_text(
        "\n".join(f"{nm:g},{value:.9g}" for nm, value in zip(WAVELENGTHS_NM, values, strict=True))
    )


@pytest.fixture(scope="module")
def plain(folder, three_lamps):
    return Capture(
        (ViewSettings((folder / "plain.exr",), outline=three_lamps.outline),),
        three_lamps.settings,
        BallSettings(0.05, "SUS304"),
        families=("incandescent", "daylight"),
    )


def spectrum_at(panorama, bearing, elevation):
    x, y = direction_to_equirectangular(bearing_to_direction(bearing, elevation), *panorama.valid.shape)
    place = int(y), int(x)
    return panorama.weights[place] @ panorama.bases[panorama.basis_index[place]]


def fit(room, panorama, lamp):
    """Goodness of fit of a lamp's spectrum, and its power over the true one."""
    bearing, elevation, _, level, truth = room.lamps[lamp]
    found, truth = spectrum_at(panorama, bearing, elevation), level * truth / truth.mean()
    return found @ truth / np.linalg.norm(found) / np.linalg.norm(truth), found.sum() / truth.sum()


def build(capture):
    return finish(build_probe(capture, WIDTH))


@pytest.fixture(scope="module")
def before(plain):
    """The probe for filament lamps and daylight."""
    return build(plain)


@pytest.fixture(scope="module")
def automatic(plain):
    """The probe of one photograph when nothing is known of the lamps."""
    return build(replace(plain, method="automatic"))


@pytest.fixture(scope="module")
def filtered(plain, folder):
    """The same capture with a photograph through the green filter."""
    view = ViewSettings((folder / "green.exr",), outline=plain.views[0].outline, filter=folder / "green.csv")
    return replace(plain, views=(*plain.views, view), method="automatic")


def test_a_second_photograph_through_a_filter_tells_the_lamps(three_lamps, automatic, filtered):
    """Without it the tube's goodness of fit is 0.84 and the filament's 0.97; with it 0.998 and 0.999."""
    better = build(filtered)
    for lamp, before, after in (("FL11", 0.90, 0.995), ("A", 0.98, 0.998), ("D65", 1.0, 0.999)):
        assert fit(three_lamps, automatic.panorama, lamp)[0] < before
        goodness, power = fit(three_lamps, better.panorama, lamp)
        assert goodness > after
        assert power == pytest.approx(1.0, abs=0.03)
    assert np.median(better.panorama.confidence) > np.median(automatic.panorama.confidence)
    assert [view["filter"] for view in better.report["views"]] == [None, "green.csv"]
    assert not any("families" in warning for warning in better.report["warnings"])


def test_what_only_the_unfiltered_photographs_saw_keeps_its_spectrum(three_lamps, filtered, automatic):
    """The filtered photograph is cut so that the ball's left half is clipped: there three channels must do."""
    from spectral_probe.files.image_exr import read_rgb, write_rgb

    path = filtered.views[1].photos[0]
    picture = read_rgb(path)
    picture[:, :100] = np.inf
    half = path.with_name("half.exr")
    write_rgb(half, picture)
    view = replace(filtered.views[1], photos=(half,))
    panorama = build(replace(filtered, views=(filtered.views[0], view))).panorama
    assert panorama.valid.all() == automatic.panorama.valid.all()
    assert fit(three_lamps, panorama, "FL11")[0] > 0.995  # on the right
    assert fit(three_lamps, panorama, "A")[0] == pytest.approx(
        fit(three_lamps, automatic.panorama, "A")[0], abs=1e-3
    )


def test_an_own_lamp_joins_the_families(three_lamps, plain, before, folder):
    after = build(replace(plain, spectra=(folder / "tube.csv",)))
    assert fit(three_lamps, before.panorama, "FL11")[0] < 0.8
    assert fit(three_lamps, after.panorama, "FL11")[0] > 0.95


@pytest.mark.parametrize(
    ("place", "known", "goodness"),
    [
        ({"polygon_deg": ROUND_THE_TUBE}, {"families": ("fluorescent-triband",)}, 0.99),
        ({"seed_deg": (60.0, 35.0)}, {"spectrum": "tube.csv"}, 0.99999),
    ],
    ids=["polygon with families", "seed with a measured spectrum"],
)
def test_a_region_has_its_own_light(three_lamps, plain, before, folder, place, known, goodness):
    known = {name: folder / value if name == "spectrum" else value for name, value in known.items()}
    panorama = build(replace(plain, regions=(RegionLight(Region(**place), **known),))).panorama
    assert fit(three_lamps, panorama, "FL11")[0] > goodness
    assert fit(three_lamps, panorama, "FL11")[1] == pytest.approx(1.0, abs=0.08)
    for lamp in ("A", "D65"):  # elsewhere nothing changes
        expected = fit(three_lamps, before.panorama, lamp)
        assert fit(three_lamps, panorama, lamp) == pytest.approx(expected, abs=1e-6)


def test_a_region_works_with_a_filter(three_lamps, filtered):
    region = RegionLight(Region(polygon_deg=ROUND_THE_TUBE), families=("fluorescent-triband",))
    capture = replace(filtered, method="family", regions=(region,))
    assert fit(three_lamps, build(capture).panorama, "FL11")[0] > 0.995


def test_bad_regions_are_named(plain):
    nowhere = RegionLight(
        Region(polygon_deg=((10.0, 5.0), (10.01, 5.0), (10.01, 5.01))), families=("daylight",)
    )
    with pytest.raises(SpectralProbeError, match="selects nothing"):
        build(replace(plain, regions=(nowhere,)))
    unknown = RegionLight(Region(seed_deg=(60.0, 35.0)), families=("neon",))
    with pytest.raises(SpectralProbeError, match='no lamp family "neon"'):
        build(replace(plain, regions=(unknown,)))


def card_capture(room, plain, folder, name, calibration, gains):
    photo = room.write(folder / f"{name}.exr", gains=gains)
    return replace(plain, views=(replace(plain.views[0], photos=(photo,)),), calibration=calibration)


def test_gains_from_a_card_put_the_colours_right(three_lamps, plain, folder):
    """Photographs whose red and blue are 0.45 and 0.7 of what the curves say: the daylight is daylight again."""
    room = replace(three_lamps, card=0.18 * illuminant("A"))
    settings = CalibrationSettings(patch_px=(6, 6, 22, 22), illuminant="A", reflectance=0.18)
    gains = (0.45, 1.0, 0.7)
    wrong = build(card_capture(room, plain, folder, "wrong", None, gains))
    right = build(card_capture(room, plain, folder, "right", settings, gains))
    assert fit(room, wrong.panorama, "D65")[0] < 0.97
    for lamp in ("A", "D65"):
        assert fit(room, right.panorama, lamp)[0] > 0.997
        assert fit(room, right.panorama, lamp)[1] == pytest.approx(1.0, abs=0.03)
    assert right.report["calibration"]["gains"] == pytest.approx([1 / 0.45, 1.0, 1 / 0.7], rel=0.005)
    assert wrong.report["calibration"] is None
    assert right.panorama.provenance["channel_gains"].count(",") == 2


def test_curves_without_gains_ask_for_a_calibration(three_lamps, plain, folder):
    """A user's own file, every curve at a peak of 1; once calibrated, nothing is said."""
    peaks = three_lamps.camera / three_lamps.camera.max(0)
    rows = [f"{nm:g},{r},{g},{b}" for nm, (r, g, b) in zip(WAVELENGTHS_NM, peaks, strict=True)]
    (folder / "camera.csv").write_text("wavelength_nm,r,g,b\n" + "\n".join(rows))
    camera = replace(plain.camera, model=None, sensitivities=folder / "camera.csv")
    lamp = CalibrationSettings(light_at=(-70.0, 25.0), illuminant="A")
    said, silent = (
        build(replace(plain, camera=camera, calibration=calibration)).report["warnings"]
        for calibration in (None, lamp)
    )
    assert len(said) == 1
    assert "the gains of its channels are lost and all colours may be tinted. Calibrate them" in said[0]
    assert not silent


def test_an_absolute_spectrum_gives_the_panorama_its_unit(three_lamps, plain, folder):
    room = replace(three_lamps, card=2.0 * illuminant("A"))
    settings = CalibrationSettings(patch_px=(6, 6, 22, 22), spectrum=folder / "A.csv", absolute=True)
    probe = build(card_capture(room, plain, folder, "absolute", settings, (0.003,) * 3))
    for lamp in ("A", "D65"):
        assert fit(room, probe.panorama, lamp)[1] == pytest.approx(1.0, abs=0.02)
    assert probe.panorama.provenance["unit"] == "W.m^-2.sr^-1.nm^-1"


def test_the_ball_is_found_brighter_than_modelled(three_lamps, plain, folder):
    """A ball of 1.15 times the reflectance: the light would be 15 % too bright, and is not."""
    room = replace(
        three_lamps,
        card=0.5 * illuminant("A"),
        reflectance=lambda cos: 1.15 * ball_reflectance("SUS304", cos),
    )
    settings = CalibrationSettings(patch_px=(6, 6, 22, 22), illuminant="A", reflectance=0.5)
    dark = replace(room, card=0 * room.card).photograph(noise=0.0)
    changed = np.abs(room.photograph(noise=0.0) - dark).max(-1)
    changed[:30, :30] = 0.0
    y, x = np.argwhere(changed > 0.9 * changed.max()).mean(0)
    with_ball = replace(settings, ball_patch_px=(x - 3, y - 3, x + 4, y + 4))
    powers = [
        fit(room, build(card_capture(room, plain, folder, "ball", one, (1.0,) * 3)).panorama, "D65")[1]
        for one in (settings, with_ball)
    ]
    assert powers[0] == pytest.approx(1.15, abs=0.03)
    assert powers[1] == pytest.approx(1.0, abs=0.03)
