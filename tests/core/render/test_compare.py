import json
import math

import cv2
import numpy as np
import pytest

from spectral_probe.errors import SpectralProbeError
from spectral_probe.render.compare import compare_images, comparison_report, write_comparison
from spectral_probe.spectra.colorimetry import chromaticity, delta_e_2000, white_xyz

# Sharma, Wu & Dalal, "The CIEDE2000 color-difference formula: implementation notes, supplementary test data, and
# mathematical observations", Color Res. Appl. 30, 21 (2005), table 1: two L*a*b* colours and their difference.
SHARMA = [
    ((50.0, 2.6772, -79.7751), (50.0, 0.0, -82.7485), 2.0425),
    ((50.0, 3.1571, -77.2803), (50.0, 0.0, -82.7485), 2.8615),
    ((50.0, 2.8361, -74.0200), (50.0, 0.0, -82.7485), 3.4412),
    ((50.0, -1.3802, -84.2814), (50.0, 0.0, -82.7485), 1.0000),
    ((50.0, 2.5, 0.0), (50.0, 0.0, -2.5), 4.3065),
    ((50.0, 2.5, 0.0), (73.0, 25.0, -18.0), 27.1492),
    ((50.0, 2.5, 0.0), (61.0, -5.0, 29.0), 22.8977),
    ((60.2574, -34.0099, 36.2677), (60.4626, -34.1751, 39.4387), 1.2644),
    ((2.0776, 0.0795, -1.1350), (0.9033, -0.0636, -0.5514), 0.9082),
]


def xyz_of_lab(lab):
    """The CIE's inverse of L*a*b* relative to our D65, Y = 1."""
    lightness, a, b = lab
    f = np.array([(lightness + 16) / 116 + a / 500, (lightness + 16) / 116, (lightness + 16) / 116 - b / 200])
    linear = np.where(f > 6 / 29, f**3, 3 * (6 / 29) ** 2 * (f - 4 / 29))
    return linear * white_xyz("D65")


def flat(xyz, size=(6, 8)):
    return np.broadcast_to(np.asarray(xyz, float), (*size, 3)).copy()


@pytest.fixture
def picture(rng):
    """An image of smooth colours, (40, 60, 3)."""
    coarse = rng.uniform(0.1, 1.0, (4, 6, 3)) * white_xyz()
    return cv2.resize(coarse, (60, 40), interpolation=cv2.INTER_CUBIC).clip(0.01)


@pytest.fixture
def rng():
    return np.random.default_rng(7)


def test_identical_images_differ_by_nothing(picture):
    comparison = compare_images(
        picture, picture.copy(), object_masks={"all": np.ones((40, 60), bool)}, blur_px=2
    )
    for region in (comparison.image, *comparison.objects):
        for numbers in (region.raw, region.blurred):
            assert (numbers.mean, numbers.median, numbers.p95, numbers.max) == (0, 0, 0, 0)
            assert (numbers.above_1, numbers.above_2, numbers.pixels) == (0, 0, 2400)
        assert region.xy_shift == (0, 0)
        assert region.delta_e_of_means == 0
    assert not comparison.delta_e.any()


@pytest.mark.parametrize(("lab_a", "lab_b", "published"), SHARMA)
def test_published_colour_differences(lab_a, lab_b, published):
    comparison = compare_images(flat(xyz_of_lab(lab_a)), flat(xyz_of_lab(lab_b)), white_luminance=1.0)
    np.testing.assert_allclose(comparison.delta_e, published, atol=1e-4)
    assert comparison.image.delta_e_of_means == pytest.approx(published, abs=1e-4)


def test_both_images_are_scaled_by_one_white(picture):
    darker = picture * 0.9
    comparison = compare_images(picture, darker)
    white = white_xyz("D65") * np.percentile(picture[..., 1], 95)
    np.testing.assert_allclose(comparison.white_xyz, white)
    np.testing.assert_allclose(comparison.delta_e, delta_e_2000(picture, darker, white), rtol=1e-5)
    assert comparison.image.raw.mean > 1  # a darker image is not the same image
    scaled = compare_images(picture * 1000, darker * 1000)
    np.testing.assert_allclose(scaled.delta_e, comparison.delta_e, rtol=1e-5)


def test_statistics_count_pixels():
    same, other = xyz_of_lab((50, 0, 0)), xyz_of_lab((50, 2.5, 0))
    spectral, rgb = flat(same, (10, 10)), flat(same, (10, 10))
    rgb[:3] = other
    comparison = compare_images(spectral, rgb, white_luminance=1.0)
    difference = float(delta_e_2000(same, other, white_xyz()))
    numbers = comparison.image.raw
    assert difference > 2
    assert numbers.mean == pytest.approx(0.3 * difference)
    assert numbers.median == 0
    assert numbers.max == pytest.approx(difference)
    assert (numbers.above_1, numbers.above_2) == (0.3, 0.3)


def test_shift_of_chromaticity_is_the_light_added_up():
    spectral, rgb = flat((0.30, 0.40, 0.30)), flat((0.36, 0.40, 0.24))
    region = compare_images(spectral, rgb).image
    assert region.xy_spectral == pytest.approx((0.3, 0.4))
    assert region.xy_rgb == pytest.approx((0.36, 0.4))
    assert region.xy_shift == pytest.approx((0.06, 0.0))
    spectral[0] *= 5  # bright pixels weigh more: the light is added, not the coordinates
    spectral[0, :, 0] *= 2
    assert compare_images(spectral, rgb).image.xy_spectral == pytest.approx(
        tuple(chromaticity(spectral.reshape(-1, 3).sum(0)))
    )


def test_objects_by_their_masks(picture):
    rgb = picture.copy()
    left = np.zeros((40, 60), bool)
    left[:, :30] = True
    rgb[left] *= (1.1, 1.0, 0.9)
    nowhere = np.zeros((40, 60), bool)
    comparison = compare_images(picture, rgb, object_masks={"gold": left, "silver": ~left, "behind": nowhere})
    gold, silver = comparison.objects
    assert (gold.name, silver.name) == ("gold", "silver")
    assert gold.raw.mean == pytest.approx(comparison.delta_e[left].mean())
    assert gold.raw.pixels == silver.raw.pixels == 1200
    assert gold.raw.mean > 3
    assert silver.raw.max == 0
    assert silver.xy_shift == (0, 0)
    assert comparison.unseen_objects == ("behind",)
    assert comparison.image.raw.mean == pytest.approx(gold.raw.mean / 2)


def test_what_is_not_a_number_or_black_in_both_is_left_out(picture):
    spectral, rgb = picture.copy(), picture * 0.9
    spectral[0, 0, 1] = np.nan
    rgb[0, 1] = np.inf
    spectral[1], rgb[1] = 0, -1e-3
    rgb[2] = 0  # black in one image only: a difference like any other
    comparison = compare_images(spectral, rgb, white_luminance=1.0, blur_px=1.5)
    assert not comparison.valid[0, :2].any()
    assert not comparison.valid[1].any()
    assert comparison.valid.sum() == 2400 - 2 - 60
    assert comparison.not_finite == (1, 1)
    assert np.isnan(comparison.delta_e[~comparison.valid]).all()
    assert np.isfinite(comparison.delta_e_blurred[comparison.valid]).all()
    assert comparison.image.raw.pixels == 2400 - 2 - 60
    assert comparison.delta_e[2].min() > 20
    far = np.zeros((40, 60), bool)
    far[20:] = True  # beyond the blur's reach of the holes nothing changes
    whole = compare_images(picture, picture * 0.9, white_luminance=1.0, blur_px=1.5)
    np.testing.assert_allclose(comparison.delta_e_blurred[far], whole.delta_e_blurred[far], rtol=1e-5)


def test_highlights_are_clipped_alike_and_counted():
    spectral, rgb = flat(white_xyz() * 0.5), flat(white_xyz() * 0.5)
    spectral[0], rgb[0] = white_xyz() * 40, white_xyz() * 90
    comparison = compare_images(spectral, rgb, white_luminance=1.0)
    assert comparison.image.raw.max == 0
    assert comparison.clipped_fraction == pytest.approx(1 / 6)


def test_the_blur_is_plain_gaussian_on_both_before_the_difference(picture, rng):
    noisy = picture * rng.normal(1, 0.05, picture.shape)
    comparison = compare_images(picture, noisy, white_luminance=1.0, blur_px=3.0)
    blurred = [cv2.GaussianBlur(image, (0, 0), 3.0).clip(0, 3) for image in (picture, noisy)]
    np.testing.assert_allclose(
        comparison.delta_e_blurred, delta_e_2000(*blurred, white_xyz()), rtol=1e-5, atol=1e-5
    )
    assert comparison.image.raw.mean > 2
    assert comparison.image.blurred.mean < comparison.image.raw.mean / 3
    assert comparison.image.differences is comparison.image.blurred
    assert comparison.delta_e_map is comparison.delta_e_blurred
    assert comparison.image.delta_e_of_means < 0.3


def test_numbers_as_json(picture, tmp_path):
    mask = np.zeros((40, 60), bool)
    mask[5:9, 5:9] = True
    comparison = compare_images(picture, picture * (1.0, 1.0, 0.9), object_masks={"ball": mask})
    write_comparison(tmp_path / "compare.json", comparison)
    read = json.loads((tmp_path / "compare.json").read_text())
    assert read["size_px"] == [60, 40]
    assert read["image"]["raw"]["mean"] == comparison.image.raw.mean
    assert read["image"]["blurred"] is None
    assert read["objects"][0]["name"] == "ball"
    assert read["objects"][0]["xy_shift"] == list(comparison.objects[0].xy_shift)
    assert math.isclose(read["white_xyz"][1], comparison.white_xyz[1])
    assert json.loads(json.dumps(comparison_report(comparison), allow_nan=False)) == read
    assert [path.name for path in tmp_path.iterdir()] == ["compare.json"]


@pytest.mark.parametrize(
    ("spectral", "rgb", "masks", "message"),
    [
        (np.ones((4, 6, 3)), np.ones((5, 6, 3)), {}, r"6 x 4 pixels, the RGB image 6 x 5"),
        (np.zeros((4, 6, 3)), np.zeros((4, 6, 3)), {}, r"spectral image is black in every pixel"),
        (np.zeros((4, 6, 3)), np.ones((4, 6, 3)), {}, r"spectral image is black in every pixel"),
        (np.ones((4, 6, 3)), np.zeros((4, 6, 3)), {}, r"RGB image is black in every pixel"),
        (
            np.full((4, 6, 3), np.nan),
            np.ones((4, 6, 3)),
            {},
            r"24 of the 24 pixels of the spectral image are not numb",
        ),
        (
            np.ones((4, 6, 3)),
            np.full((4, 6, 3), np.inf),
            {},
            r"24 of the 24 pixels of the RGB image are not numbers",
        ),
        (np.ones((4, 6)), np.ones((4, 6)), {}, r"three channels are needed"),
        (np.ones((4, 6, 3)), np.ones((4, 6, 3)), {"ball": np.ones((6, 4), bool)}, r'mask of "ball" is 4 x 6'),
        (np.eye(30)[..., None] * np.ones(3), np.ones((30, 30, 3)), {}, r"Give the luminance of white"),
    ],
)
def test_bad_input_is_one_clear_line(spectral, rgb, masks, message):
    with pytest.raises(SpectralProbeError, match=message) as caught:
        compare_images(spectral, rgb, object_masks=masks)
    assert "\n" not in str(caught.value)
