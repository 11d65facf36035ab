"""Calibration by what the photographs show of a known light: a card beside the ball, its reflection, a lamp in the ball."""

from dataclasses import replace

import numpy as np
import pytest

from spectral_probe.errors import CaptureError, SpectralProbeError
from spectral_probe.files.image_exr import write_rgb
from spectral_probe.geometry.frames import camera_to_world
from spectral_probe.geometry.registration import PlacedView, register_views
from spectral_probe.known_light import calibrated, check_calibration, known_spectrum
from spectral_probe.light_settings import CalibrationSettings
from spectral_probe.model import BallSettings, Capture, ViewSettings
from spectral_probe.spectra.colorimetry import illuminant
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.metals import ball_reflectance
from spectral_probe.view import measure_view

CARD = (6, 6, 22, 22)
LAMP = 2.0 * illuminant("A")


@pytest.fixture(scope="module")
def room(three_lamps):
    """With a card of 18 % beside the ball, under a filament lamp of its own."""
    return replace(three_lamps, card=0.18 * LAMP)


def csv(path, values):
    path.write_text(
        "\n".join(f"{nm:g},{value:.9g}" for nm, value in zip(WAVELENGTHS_NM, values, strict=True))
    )
    return path


def calibration_of(room, tmp_path, settings, camera=None, **how):
    """What `calibrated` says of a photograph of the room."""
    photo = room.write(tmp_path / "photo.exr", **how)
    view = ViewSettings((photo,), outline=room.outline)
    capture = Capture((view,), room.settings, BallSettings(0.05, "SUS304"), calibration=settings)
    check_calibration(capture)
    measured = [measure_view(capture, view, settings.patch_px)]
    placed = [PlacedView(one.image, one.camera, one.ball, camera_to_world(0)) for one in measured]
    camera = room.camera if camera is None else camera
    return calibrated(capture, measured, placed, register_views(placed).views, camera)


@pytest.mark.parametrize("gains", [(1.0, 1.0, 1.0), (0.45, 1.0, 0.7)])
def test_a_grey_card_gives_the_gains(room, tmp_path, gains):
    settings = CalibrationSettings(patch_px=CARD, illuminant="A", reflectance=0.18)
    found = calibration_of(room, tmp_path, settings, gains=gains)
    np.testing.assert_allclose(found.gains, 1 / np.array(gains), rtol=0.005)
    assert found.ball is None
    assert not found.warnings


def test_the_patch_follows_a_camera_held_by_hand(room, tmp_path):
    """The second photograph is 3 pixels off: without following, the patch would take in what is beside the card."""
    picture = room.photograph()
    photos = []
    for number, moved in enumerate((0, 3)):
        photos.append(tmp_path / f"{number}.exr")
        write_rgb(photos[-1], np.roll(picture, moved, axis=1))
    settings = CalibrationSettings(patch_px=(5, 5, 23, 23), illuminant="A", reflectance=0.18)
    view = ViewSettings(tuple(photos), exposures_s=(1.0, 1.0))
    patch = measure_view(Capture((view,), room.settings), view, settings.patch_px).patch
    np.testing.assert_allclose(patch.responses, picture[10, 10], rtol=0.01)
    assert not patch.uneven


def test_a_measured_lamp_gives_the_absolute_scale(room, tmp_path):
    """Photographs of 1 / 50 the light: the gain is what brings them back to the measured spectrum's unit."""
    settings = CalibrationSettings(
        patch_px=CARD, spectrum=csv(tmp_path / "lamp.csv", LAMP), reflectance=csv(tmp_path / "card.csv", np.full(61, 0.18)),
        absolute=True,
    )  # fmt: skip
    found = calibration_of(room, tmp_path, settings, gains=(0.02, 0.02, 0.02))
    np.testing.assert_allclose(found.gains, 50.0, rtol=0.01)
    assert found.absolute


def test_a_lamp_seen_in_the_ball_gives_the_gains(room, tmp_path):
    settings = CalibrationSettings(light_at=(-70.0, 25.0), illuminant="A")
    found = calibration_of(room, tmp_path, settings, gains=(0.5, 1.0, 1.5))
    np.testing.assert_allclose(found.gains, [2.0, 1.0, 1 / 1.5], rtol=0.01)
    assert found.patch.cos_incidence == pytest.approx(np.cos(np.radians(0.5 * 80)), abs=0.25)


def test_the_card_in_the_ball_gives_its_reflectance(room, tmp_path):
    """A ball 1.15 times as bright as modelled at every wavelength: found within 2 %, whatever the gains."""
    brighter = replace(room, reflectance=lambda cos: 1.15 * ball_reflectance("SUS304", cos))
    y, x = np.argwhere(brighter_card(brighter)).mean(0)
    patch = (x - 3, y - 3, x + 4, y + 4)
    settings = CalibrationSettings(patch_px=CARD, illuminant="A", reflectance=0.18, ball_patch_px=patch)
    found = calibration_of(brighter, tmp_path, settings, gains=(0.6, 1.0, 1.2))
    np.testing.assert_allclose(found.ball.factor, 1.15, rtol=0.02)
    np.testing.assert_allclose(found.gains, [1 / 0.6, 1.0, 1 / 1.2], rtol=0.005)
    assert found.described()["ball_factors"] == pytest.approx([1.15] * 3, rel=0.02)


def brighter_card(room):
    """Pixels (H, W) in which the ball mirrors the card: those that change when the card goes out."""
    with_card, without = (
        replace(room, card=card).photograph(noise=0.0) for card in (room.card, 0 * room.card)
    )
    changed = np.abs(with_card - without).max(-1) > 0.9 * np.abs(with_card - without)[100:, 60:140].max()
    changed[:30, :30] = False
    return changed


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (CalibrationSettings(patch_px=(190, 190, 210, 195), illuminant="A"), "leaves the photograph of 200 x 200"),
        (CalibrationSettings(patch_px=(10, 10, 12, 20), illuminant="A"), "smaller than 3 x 3 pixels"),
        (CalibrationSettings(patch_px=CARD, illuminant="A", view=2), "names view 2, but there are 1"),
        (CalibrationSettings(patch_px=CARD, illuminant="No Lamp"), 'no lamp called "No Lamp"'),
        (CalibrationSettings(patch_px=CARD, illuminant="A", ball_patch_px=(2, 2, 9, 9)), "does not lie on the ball"),
        (CalibrationSettings(patch_px=CARD, illuminant="A", ball_patch_px=(98, 14, 103, 19)), "on the ball's rim"),
        (CalibrationSettings(light_at=(0.0, 0.0), illuminant="A"), "no view sees light_at"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_named(room, tmp_path, settings, message):
    with pytest.raises(SpectralProbeError, match=message) as caught:
        calibration_of(room, tmp_path, settings)
    assert "\n" not in str(caught.value)


def test_a_clipped_and_a_dark_patch_are_named(room, tmp_path):
    import cv2

    settings = CalibrationSettings(patch_px=CARD, illuminant="A")
    for level, message in ((3.0, "clipped in every photograph"), (1e-5, "too dark to calibrate by")):
        picture = room.photograph()
        picture = np.clip(picture * level / picture[10, 10].max(), 0, 1)
        path = tmp_path / f"{level}.tif"
        assert cv2.imwrite(str(path), np.round(picture[..., ::-1] * 65535).astype(np.uint16))
        view = ViewSettings((path,), outline=room.outline, exposures_s=(0.01,))
        capture = Capture((view,), room.settings, calibration=settings)
        with pytest.raises(CaptureError, match=message):
            measure_view(capture, view, settings.patch_px)


def test_an_uneven_patch_warns(room, tmp_path):
    settings = CalibrationSettings(patch_px=(6, 6, 40, 40), illuminant="A", reflectance=0.18)
    assert any("uneven" in warning for warning in calibration_of(room, tmp_path, settings).warnings)


def test_a_wrong_spectrum_warns(room, tmp_path):
    settings = CalibrationSettings(
        patch_px=CARD, spectrum=csv(tmp_path / "blue.csv", np.linspace(1, 0, 61) ** 6)
    )
    warnings = calibration_of(room, tmp_path, settings).warnings
    assert any("check the place and the spectrum" in warning for warning in warnings)


def test_percent_and_negative_light_are_named(tmp_path):
    percent = CalibrationSettings(
        patch_px=CARD, illuminant="A", reflectance=csv(tmp_path / "p.csv", np.full(61, 18.0))
    )
    with pytest.raises(SpectralProbeError, match=r"fractions between 0 and 1|percent"):
        known_spectrum(percent)
    negative = CalibrationSettings(patch_px=CARD, spectrum=csv(tmp_path / "n.csv", np.linspace(-1, 1, 61)))
    with pytest.raises(SpectralProbeError, match="negative"):
        known_spectrum(negative)


def test_a_view_through_a_filter_does_not_calibrate(tmp_path):
    view = ViewSettings((tmp_path / "a.exr",))
    settings = CalibrationSettings(patch_px=CARD, illuminant="A", view=2)
    with pytest.raises(CaptureError, match="through a filter"):
        check_calibration(Capture((view, replace(view, filter="green")), calibration=settings))
