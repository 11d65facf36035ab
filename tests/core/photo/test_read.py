"""Photographs of every kind against values written by the test itself."""

from pathlib import Path

import cv2
import numpy as np
import OpenEXR
import pytest
from PIL import Image

from spectral_probe.errors import PhotographError
from spectral_probe.photo.raw import saturation_level, turned
from spectral_probe.photo.read import EXIF_IFD, read_photograph, srgb_to_linear

BLACK, WHITE = 512, 16383


def write_dng(path: Path, sensels: np.ndarray, time_s: float = 0.01) -> None:
    """A 14-bit RGGB mosaic as the smallest DNG that LibRaw reads."""
    import tifffile

    identity = (1, 1, 0, 1, 0, 1, 0, 1, 1, 1, 0, 1, 0, 1, 0, 1, 1, 1)
    tifffile.imwrite(
        path,
        sensels.astype(np.uint16),
        photometric=32803,
        metadata=None,
        extratags=[
            (271, "s", 0, "Test", True),
            (272, "s", 0, "Mosaic", True),
            (33421, "H", 2, (2, 2), True),
            (33422, "B", 4, bytes([0, 1, 1, 2]), True),
            (33434, "2I", 1, (round(time_s * 1e6), 1000000), True),
            (33437, "2I", 1, (8, 1), True),
            (34855, "H", 1, 200, True),
            (37386, "2I", 1, (50, 1), True),
            (50706, "B", 4, bytes([1, 4, 0, 0]), True),
            (50708, "s", 0, "Test Mosaic", True),
            (50714, "H", 1, BLACK, True),
            (50717, "H", 1, WHITE, True),
            (50721, "2i", 9, identity, True),
            (50728, "2I", 3, (1, 1, 1, 1, 1, 1), True),
        ],
    )


def mosaic(rgb: tuple[float, float, float], shape: tuple[int, int] = (96, 128)) -> np.ndarray:
    """Noiseless sensels of a uniform colour, 1 = saturation."""
    sensels = np.empty(shape)
    sensels[0::2, 0::2], sensels[1::2, 1::2] = rgb[0], rgb[2]
    sensels[0::2, 1::2] = sensels[1::2, 0::2] = rgb[1]
    return BLACK + sensels * (WHITE - BLACK)


def test_raw_values_are_the_sensels_own(tmp_path):
    write_dng(tmp_path / "a.dng", mosaic((0.2, 0.5, 0.1)))
    photograph = read_photograph(tmp_path / "a.dng")
    assert photograph.pixels.dtype == np.float32
    # 14 bits: half a level is 3e-5. No white balance, no gamma, black at 0.
    np.testing.assert_allclose(photograph.pixels[10:-10, 10:-10].mean((0, 1)), (0.2, 0.5, 0.1), atol=5e-5)
    assert not photograph.clipped.any()
    assert photograph.exposure.time_s == pytest.approx(0.01)
    assert (photograph.exposure.iso, photograph.exposure.f_number) == (200, 8)
    assert photograph.focal_mm == 50
    assert not photograph.display_referred


def test_raw_noise_below_black_is_kept(tmp_path):
    noise = np.random.default_rng(0).normal(0.0, 4.0, (96, 128))
    write_dng(tmp_path / "dark.dng", np.round(BLACK + noise))
    pixels = read_photograph(tmp_path / "dark.dng").pixels
    # Cut at 0 the mean would be 0.4 sigma = 1.6 levels. AHD averages, the mean stays.
    assert abs(float(pixels.mean()) * (WHITE - BLACK)) < 0.3
    assert pixels.min() < 0


def test_raw_white_does_not_depend_on_the_picture(tmp_path):
    for name, level in (("dim.dng", 0.6), ("bright.dng", 0.9)):
        write_dng(tmp_path / name, mosaic((level, level, level)))
        assert float(np.median(read_photograph(tmp_path / name).pixels)) == pytest.approx(level, abs=1e-4)


def test_raw_clipping_reaches_as_far_as_demosaicing(tmp_path):
    sensels = mosaic((0.3, 0.3, 0.3))
    sensels[40, 60] = WHITE
    write_dng(tmp_path / "spot.dng", sensels)
    clipped = read_photograph(tmp_path / "spot.dng").clipped
    rows, columns = np.nonzero(clipped)
    assert (rows.min(), rows.max(), columns.min(), columns.max()) == (38, 42, 58, 62)
    pixels = read_photograph(tmp_path / "spot.dng").pixels
    assert np.abs(pixels[~clipped] - 0.3).max() < 0.003


def test_pile_up_below_the_white_level_is_saturation():
    rng = np.random.default_rng(1)
    scene = rng.uniform(600, 12000, 5000)
    assert saturation_level(np.r_[scene, np.full(500, 15800)], WHITE) == 15800
    assert saturation_level(scene, WHITE) == WHITE


def test_raw_is_turned_like_its_clipped_mask():
    image = np.arange(6).reshape(2, 3)
    assert turned(image, 6).shape == (3, 2)
    assert turned(image, 6)[0].tolist() == [3, 0]
    assert turned(image, 3)[0, 0] == 5


def test_shared_raw_agrees_with_its_sensels(shared_dir):
    import rawpy

    path = shared_dir / "captures/gym/view0_2.dng"
    photograph = read_photograph(path)
    with rawpy.imread(str(path)) as raw:
        expected = (raw.raw_image_visible.astype(float) - BLACK) / (WHITE - BLACK)
        colours = raw.raw_colors_visible
        for channel in range(3):
            own = colours == channel
            assert np.abs(photograph.pixels[..., channel][own] - expected[own]).max() < 1e-4
    assert photograph.exposure.time_s == pytest.approx(0.008, rel=1e-4)
    assert photograph.exposure.iso == 100  # the file says 0
    assert 0.005 < photograph.clipped.mean() < 0.05


@pytest.mark.parametrize("suffix", [".png", ".tif"])
def test_16_bit_is_linear_rgb(tmp_path, suffix):
    image = np.random.default_rng(2).integers(0, 60000, (20, 30, 3), np.uint16)
    image[3, 4, 1] = 65535
    cv2.imwrite(str(tmp_path / f"a{suffix}"), image[..., ::-1])
    photograph = read_photograph(tmp_path / f"a{suffix}")
    np.testing.assert_allclose(photograph.pixels, image / 65535.0, atol=1e-6)
    assert np.argwhere(photograph.clipped).tolist() == [[3, 4]]
    assert photograph.exposure is None
    assert not photograph.display_referred


def test_jpeg_is_srgb_decoded_upright_and_has_its_exif(tmp_path):
    image = np.full((32, 64, 3), (200, 100, 50), np.uint8)
    image[:, :32] = (250, 254, 252)
    exif = Image.Exif()
    exif[0x0112] = 6  # the camera was turned clockwise: show the first row on the right
    details = exif.get_ifd(EXIF_IFD)
    details[0x829A], details[0x8827], details[0x829D] = 0.004, 400, 5.6
    details[0x920A], details[0xA405] = 16.0, 24
    Image.fromarray(image).save(tmp_path / "a.jpg", quality=98, subsampling=0, exif=exif)
    photograph = read_photograph(tmp_path / "a.jpg")
    assert photograph.pixels.shape == (64, 32, 3)
    expected = srgb_to_linear(np.array([200, 100, 50]) / 255.0)
    np.testing.assert_allclose(photograph.pixels[40:].mean((0, 1)), expected, rtol=0.02)
    assert photograph.clipped[:24].all()
    assert not photograph.clipped[40:].any()
    assert photograph.exposure.relative == pytest.approx(0.004 * 4 / 5.6**2)
    assert (photograph.focal_mm, photograph.focal_35mm) == (16.0, 24.0)
    assert photograph.display_referred


def test_wide_gamut_jpeg_is_brought_to_srgb(tmp_path):
    from PIL import ImageCms

    # A profile whose name is not sRGB is converted; Lab stands for any other and must not be taken as it is.
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    Image.new("RGB", (16, 16), (120, 90, 200)).save(tmp_path / "a.png", icc_profile=profile)
    pixels = read_photograph(tmp_path / "a.png").pixels
    np.testing.assert_allclose(pixels[0, 0], srgb_to_linear(np.array([120, 90, 200]) / 255.0), atol=1e-6)


def test_exr_is_radiance_and_never_clips(tmp_path):
    image = np.random.default_rng(3).uniform(0, 50, (8, 10, 3)).astype(np.float32)
    image[2, 3, 0] = np.nan
    OpenEXR.File({}, {"RGB": OpenEXR.Channel(image)}).write(str(tmp_path / "a.exr"))
    photograph = read_photograph(tmp_path / "a.exr")
    assert np.argwhere(photograph.clipped).tolist() == [[2, 3]]
    assert photograph.pixels[2, 3].tolist() == [0, 0, 0]
    np.testing.assert_array_equal(photograph.pixels[4], image[4])
    assert photograph.scene_referred_float


def test_hdr_is_radiance_in_rgb_order(tmp_path):
    image = np.full((16, 16, 3), (8.0, 2.0, 0.5), np.float32)
    cv2.imwrite(str(tmp_path / "a.hdr"), image[..., ::-1])
    photograph = read_photograph(tmp_path / "a.hdr")
    np.testing.assert_allclose(photograph.pixels[4, 4], (8.0, 2.0, 0.5), rtol=0.01)
    assert photograph.scene_referred_float


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("absent.jpg", None, "There is no photograph"),
        ("broken.jpg", b"\xff\xd8\xff\xe0 broken", "cannot be read"),
        ("broken.png", b"\x89PNG\r\n\x1a\n" + b"\0" * 40, "cannot be read"),
        ("broken.exr", b"no picture", "cannot be read"),
        ("broken.hdr", b"no picture", "cannot be read"),
        ("empty.tif", b"", "cannot be read"),
        ("broken.dng", b"no picture", "no photograph this program knows"),
        ("notes.txt", b"no picture", "no photograph this program knows"),
    ],
)
def test_bad_files_are_named(tmp_path, name, content, message):
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(PhotographError, match=message) as error:
        read_photograph(path)
    assert name in str(error.value)
    assert "\n" not in str(error.value)


def test_truncated_jpeg_is_refused(tmp_path):
    noise = np.random.default_rng(4).integers(0, 255, (200, 200, 3), np.uint8)
    Image.fromarray(noise).save(tmp_path / "a.jpg")
    data = (tmp_path / "a.jpg").read_bytes()
    (tmp_path / "a.jpg").write_bytes(data[: len(data) // 2])
    with pytest.raises(PhotographError, match=r"a\.jpg cannot be read"):
        read_photograph(tmp_path / "a.jpg")


@pytest.mark.parametrize(("suffix", "dtype"), [(".png", np.uint8), (".jpg", np.uint8), (".png", np.uint16)])
def test_grey_pictures_are_refused(tmp_path, suffix, dtype):
    cv2.imwrite(str(tmp_path / f"g{suffix}"), np.full((20, 20), 90, dtype))
    with pytest.raises(PhotographError, match="has no colour"):
        read_photograph(tmp_path / f"g{suffix}")
