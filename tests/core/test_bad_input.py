"""Bad input gets one sentence, before any photograph is read."""

import json

import numpy as np
import pytest

from spectral_probe.errors import CaptureError, SpectralDataError, SpectralProbeError
from spectral_probe.files.atomic import written_whole
from spectral_probe.files.capture import load_capture
from spectral_probe.files.region_json import read_region
from spectral_probe.files.spectrum_file import read_curves
from spectral_probe.filters import filter_sets
from spectral_probe.known_light import known_spectrum
from spectral_probe.light_settings import CalibrationSettings, Region, RegionLight
from spectral_probe.model import BallSettings, CameraSettings, Capture, ViewSettings
from spectral_probe.probe import build_probe
from spectral_probe.spectra.curves import LIGHT
from spectral_probe.spectra.regions import read_mask

_ROWS = "400,{0}\n420,{0}\n440,{0}\n" + "".join(f"{nm},{{0}}\n" for nm in range(460, 701, 20))


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("long.csv", "400," + "1" * 200_000 + "\n700,1\n"),
        ("deep.json", "[" * 100_000),
        ("huge.csv", _ROWS.format("1e300")),
        ("faint.csv", _ROWS.format("1e-300")),
    ],
)
def test_spectra_that_cannot_be_are_refused(tmp_path, name, text):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(SpectralDataError, match=name):
        read_curves(path, LIGHT)


@pytest.mark.parametrize(
    "text", ["a = " + "[" * 100_000, "a = " + "9" * 5000, "[camera]\nfocal_mm = 1" + "0" * 400]
)
def test_captures_with_endless_values_are_refused(tmp_path, text):
    path = tmp_path / "capture.toml"
    path.write_text(text + '\n[[view]]\nphotos = ["a.dng"]\n')
    with pytest.raises(CaptureError, match=r"capture\.toml"):
        load_capture(path)


def test_names_too_long_for_a_file_are_not_there(tmp_path):
    path = tmp_path / "capture.toml"
    path.write_text(f'[[view]]\nphotos = ["{"a" * 5000}.dng"]\n')
    with pytest.raises(CaptureError, match="there is no file"):
        load_capture(path)


def _capture(tmp_path, **changes):
    camera = CameraSettings(model="Nikon 5100 (NPL)")
    return Capture(views=(ViewSettings(photos=(tmp_path / "not read.dng",)),), camera=camera, **changes)


def test_the_ball_is_checked_before_any_photograph_is_read(tmp_path):
    with pytest.raises(SpectralProbeError, match="unobtainium"):
        list(build_probe(_capture(tmp_path, ball=BallSettings(material="unobtainium"))))


def test_bearings_of_regions_are_checked_before_any_photograph_is_read(tmp_path):
    region = RegionLight(Region(seed_deg=(0.0, 100.0)), ("daylight",))
    with pytest.raises(SpectralProbeError, match="elevation 100"):
        list(build_probe(_capture(tmp_path, regions=(region,))))


def test_more_filters_than_a_pixel_has_weights_for_are_refused():
    views = [ViewSettings(photos=(), filter=name) for name in (None, "red", "yellow", "green", "orange")]
    assert len(filter_sets(views[:4]).transmittances) == 4
    with pytest.raises(CaptureError, match="4 filters"):
        filter_sets(views)


def test_a_black_card_shows_no_light(tmp_path):
    card = tmp_path / "card.csv"
    card.write_text(_ROWS.format(0))
    settings = CalibrationSettings(patch_px=(0, 0, 9, 9), illuminant="A", reflectance=card)
    with pytest.raises(CaptureError, match=r"card\.csv is black"):
        known_spectrum(settings)


def test_products_in_one_thread_are_products():
    from spectral_probe.parallel import product

    random = np.random.default_rng(0)
    matrix, columns = random.random((61, 12), np.float32), random.random((12, 10_001), np.float32)
    assert np.allclose(product(matrix, columns), matrix @ columns, rtol=1e-5)


@pytest.mark.parametrize(
    "damage",
    [
        lambda light: light["estimates"][0].update(share=-1),
        lambda light: light["estimates"][0].update(operator=[[1e308] * 61] * 3),
        lambda light: light["estimates"][0].update(error_components=[[float("nan")] * 61]),
        lambda light: light.update(sensitivities=[[1e308] * 3] * 61),
        lambda light: light.pop("estimates"),
    ],
)
def test_a_recovery_damaged_in_the_header_is_said_to_be(damage):
    from spectral_probe.model import SpectralPanorama
    from spectral_probe.spectra.camera import camera_sensitivities
    from spectral_probe.spectra.grid import WAVELENGTHS_NM
    from spectral_probe.spectra.recorded import ENTRY, light_posterior, record
    from spectral_probe.spectra.recovery import spectral_recovery

    recovery = spectral_recovery(camera_sensitivities("Nikon 5100 (NPL)"), ["daylight"], "paper")
    entry = json.loads(json.dumps(record([(0, recovery)], 1.0)))
    everywhere = np.ones((4, 8), bool)

    def panorama():
        return SpectralPanorama(
            weights=np.ones((4, 8, 3), np.float32),
            bases=recovery.bases,
            basis_index=np.zeros((4, 8), np.uint8),
            wavelengths_nm=WAVELENGTHS_NM,
            valid=everywhere,
            confidence=np.ones((4, 8), np.float32),
            provenance={},
            further={ENTRY: entry},
        )

    assert light_posterior(panorama(), everywhere) is not None
    damage(entry["lights"][0])
    with pytest.raises(SpectralProbeError, match="header is damaged"):
        light_posterior(panorama(), everywhere)


def test_a_bearing_beyond_all_numbers_is_none(tmp_path):
    path = tmp_path / "region.json"
    path.write_text('{"seed_deg": [1' + "0" * 400 + ", 0]}")
    with pytest.raises(SpectralProbeError, match="no bearing"):
        read_region(path)


def test_an_empty_mask_is_no_picture(tmp_path):
    path = tmp_path / "mask.png"
    path.write_bytes(b"")
    with pytest.raises(SpectralProbeError, match=r"mask.png cannot be read as a picture"):
        read_mask(path, 4, 8)


def test_a_place_that_cannot_be_written_to_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with (
        pytest.raises(SpectralProbeError, match="cannot be written"),
        written_whole(tmp_path / "file" / "a.txt") as temporary,
    ):
        temporary.write_text("a")


def test_a_tiff_of_a_few_bytes_has_no_tags(tmp_path):
    """Found by fuzzing: Pillow's own struct.error."""
    from spectral_probe.photo.tiff import exif_of_tiff

    path = tmp_path / "a.tif"
    path.write_bytes(b"MM\0*")
    assert exif_of_tiff(path) == {}


def test_a_cryptomatte_without_all_its_channels_is_damaged():
    """Found by fuzzing."""
    from spectral_probe.errors import FileFormatError
    from spectral_probe.files.cryptomatte import object_shares

    with pytest.raises(FileFormatError, match="cryptomatte is damaged"):
        object_shares({"CryptoObject00.b": np.zeros((2, 2), np.float32)}, ["Cube"])


@pytest.mark.parametrize("name", ["a.toml", "a.json", "plan.json", "a.csv", "a.dng"])
def test_a_pipe_is_refused_and_not_waited_for(tmp_path, name):
    import os

    from spectral_probe.photo.file_kind import file_kind
    from spectral_probe.render.plan_file import load_plan

    if not hasattr(os, "mkfifo"):
        pytest.skip("this system has no named pipes")
    readers = {
        "a.toml": load_capture, "a.json": read_region, "plan.json": load_plan, "a.dng": file_kind,
        "a.csv": lambda path: read_curves(path, LIGHT),
    }  # fmt: skip
    os.mkfifo(tmp_path / name)
    with pytest.raises(SpectralProbeError):
        readers[name](tmp_path / name)


@pytest.mark.parametrize("size", [[0, 200], [200, 0], [-1, 5]])
def test_a_calibration_of_no_size_is_none(tmp_path, size):
    from spectral_probe.geometry.camera import camera_for
    from spectral_probe.model import Photograph

    path = tmp_path / "camera.json"
    path.write_text(json.dumps({"focal_px": [9, 9], "principal_px": [1, 1], "image_size_px": size}))
    photograph = Photograph(tmp_path / "a.dng", np.zeros((4, 6, 3), np.float32), np.zeros((4, 6), bool))
    with pytest.raises(CaptureError, match="not a camera calibration"):
        camera_for(CameraSettings(calibration=path), photograph)


def test_a_mean_confidence_that_rounding_put_above_one_has_no_error():
    """The mean of single precision ones: it was not a number, and neither was the band drawn from it."""
    from spectral_probe.spectra.confidence import error_of_confidence

    assert error_of_confidence(1.0000001) == 0.0


def test_a_profile_whose_curve_leaves_all_numbers_is_none():
    """Found by fuzzing: powers of thousands, slopes of zero."""
    import io
    import struct

    from PIL import ImageCms

    from spectral_probe.photo.profile import read_profile

    data = bytearray(ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes())
    assert read_profile(bytes(data)) is not None
    at = data.index(b"para") + 12
    for numbers in ((0x7FFFFFFF, 0x7FFFFFFF, 0x7FFFFFFF), (0x10000, 0, 0x10000)):
        struct.pack_into(">3i", data, at, *numbers)
        found = read_profile(io.BytesIO(data).getvalue())
        assert found is None or np.isfinite(found.curves).all()
