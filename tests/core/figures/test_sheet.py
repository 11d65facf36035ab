import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from spectral_probe.errors import SpectralProbeError
from spectral_probe.figures.difference import (
    CEILINGS,
    delta_e_ceiling,
    delta_e_colours,
    delta_e_figure,
    delta_e_picture,
)
from spectral_probe.figures.display import exposure_for_white, tone_map
from spectral_probe.figures.pair import shown_pair, wipe_picture
from spectral_probe.figures.sheet import SheetContent, comparison_sheet
from spectral_probe.figures.spectrum import SpectrumPlot
from spectral_probe.figures.style import save_figure
from spectral_probe.figures.table import difference_rows
from spectral_probe.render.compare import compare_images
from spectral_probe.render.rgb_ways import compare_rgb_ways, metal_reflectances
from spectral_probe.spectra.colorimetry import white_xyz
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.library import planck


@pytest.fixture(scope="module")
def content():
    rng = np.random.default_rng(5)
    spectral = rng.uniform(0.2, 0.8, (24, 36, 1)) * white_xyz()
    rgb = spectral.copy()
    ball = np.zeros((24, 36), bool)
    ball[6:18, 6:18] = True
    rgb[ball] *= (1.03, 1.0, 0.95)
    comparison = compare_images(spectral, rgb, object_masks={"gold": ball}, blur_px=1.0)
    ways = compare_rgb_ways(metal_reflectances(["gold", "silver"]), planck(2856.0), "a lamp")
    lamp = SpectrumPlot(
        "Lamp",
        WAVELENGTHS_NM,
        planck(2800.0),
        planck(2856.0),
        bearing_deg=(200.0, 40.0),
        measured_label="true",
    )
    return SheetContent(
        comparison, spectral, rgb, ways, split=0.3, title="Three balls", subtitle="at noon",
        panorama=rng.integers(0, 255, (32, 64, 3), dtype=np.uint8), spectra=(lamp, lamp),
        numbers={"Passes": "5", "Seconds": "41"},
    )  # fmt: skip


@pytest.fixture(scope="module")
def sheet(content):
    return comparison_sheet(content)


@pytest.fixture(scope="module")
def again(content):
    """The same sheet, drawn a second time."""
    return comparison_sheet(content)


def test_sheet_shows_everything(sheet, content):
    words = {text.get_text() for text in sheet.texts}
    for expected in ("Three balls", "at noon", "Lamp", "Spectral render", "Cycles RGB render", "Colour difference ΔE₀₀",
                     "Wipe", "Chromaticity, CIE 1931 2°", "Four ways of RGB",
                     "metals under a lamp", "Differences in numbers", "Passes", "41"):  # fmt: skip
        assert expected in words
    assert [text.get_text() for text in sheet.texts if text.get_text() in list("abcdefghij")] == list(
        "abcdefghij"
    )
    shown = [np.asarray(image.get_array()) for axes in sheet.axes for image in axes.images]
    exposure = exposure_for_white(content.comparison.white_xyz[1])
    pair = (
        tone_map(content.xyz_spectral, exposure),
        tone_map(content.xyz_rgb, exposure),
    )  # one exposure for both
    assert all(
        map(np.array_equal, pair, shown_pair(content.comparison, content.xyz_spectral, content.xyz_rgb))
    )
    for picture in (
        content.panorama,
        *pair,
        wipe_picture(*pair, 0.3),
        delta_e_picture(content.comparison),
    ):
        assert any(image.shape == picture.shape and (image == picture).all() for image in shown)


def test_table_holds_the_comparison(sheet, content):
    cells = {text.get_text() for axes in sheet.axes for text in axes.texts}
    (gold,) = content.comparison.objects
    assert f"{gold.blurred.mean:.2f}" in cells
    assert f"{gold.xy_spectral[0]:.4f}, {gold.xy_spectral[1]:.4f}" in cells
    names = [row[0] for row in difference_rows(content.comparison)]
    assert names == ["gold", "image, σ 1 px", "image, raw"]
    assert difference_rows(content.comparison)[2][1] == f"{content.comparison.image.raw.mean:.2f}"


def test_where_a_spectrum_was_read_is_ringed(sheet):
    panorama = next(axes for axes in sheet.axes if axes.get_xlim() == (-90, 270))
    rings = {(float(line.get_xdata()[0]), float(line.get_ydata()[0])) for line in panorama.lines}
    assert rings == {(200.0, 40.0)}


def test_sheet_without_light_is_shorter(sheet, content):
    plain = comparison_sheet(
        SheetContent(content.comparison, content.xyz_spectral, content.xyz_rgb, content.ways)
    )
    assert plain.get_size_inches()[0] == sheet.get_size_inches()[0]
    assert plain.get_size_inches()[1] < sheet.get_size_inches()[1] - 3


def test_no_text_leaves_the_page(sheet):
    renderer = sheet.canvas.get_renderer()
    width, height = sheet.canvas.get_width_height()
    boxes = [text.get_window_extent(renderer) for text in sheet.texts if text.get_text()]
    assert all(box.x0 >= 0 and box.x1 <= width and box.y0 >= 0 and box.y1 <= height for box in boxes)


def test_png_has_its_size_and_is_the_same_every_time(sheet, again, tmp_path):
    save_figure(sheet, tmp_path / "a.png")
    save_figure(again, tmp_path / "b.png")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    with Image.open(tmp_path / "a.png") as read:
        assert read.size == (1800, round(sheet.get_size_inches()[1] * 150))
        pixels = np.asarray(read.convert("RGB"))
    assert (pixels[:20] == 255).all()
    assert (pixels != 255).any(-1).mean() > 0.2


def test_svg_is_xml_and_the_same_every_time(sheet, again, tmp_path):
    save_figure(sheet, tmp_path / "a.svg")
    save_figure(again, tmp_path / "b.svg")
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    root = ET.parse(tmp_path / "a.svg").getroot()  # noqa: S314  # our own file
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    assert float(root.get("width").removesuffix("pt")) == pytest.approx(864, abs=0.1)  # 12 in
    assert len(root.findall(".//{http://www.w3.org/2000/svg}image")) >= 5


def test_unknown_picture_formats_are_refused(sheet, tmp_path):
    with pytest.raises(SpectralProbeError, match=r"\.png or \.svg"):
        save_figure(sheet, tmp_path / "sheet.jpeg")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("factor", "ceiling"), [(1.001, 2.0), (0.9, 5.0), (0.05, 50.0)])
def test_scale_ends_above_what_is_there(factor, ceiling):
    image = np.full((5, 5, 3), 0.5) * white_xyz()
    comparison = compare_images(image, image * factor, white_luminance=1.0)
    assert delta_e_ceiling(comparison) == ceiling
    assert ceiling in CEILINGS


def test_map_colours_and_unseen_pixels():
    image = np.full((12, 40, 3), 0.5) * white_xyz()
    other = image.copy()
    other[:, 20:] *= 0.9
    other[:, 30:] = np.nan
    comparison = compare_images(image, other, white_luminance=1.0)
    picture = delta_e_picture(comparison)
    assert (picture[:, :20] == np.rint(255 * np.array(delta_e_colours()(0.0)[:3]))).all()
    level = float(comparison.delta_e[0, 20]) / delta_e_ceiling(comparison)
    np.testing.assert_allclose(picture[0, 20], 255 * np.array(delta_e_colours()(level)[:3]), atol=1)
    assert (np.ptp(picture[:, 30:].astype(int), axis=-1) == 0).all()
    assert picture[:, 30:].min() > 190
    lightness = np.array([0.2126, 0.7152, 0.0722]) @ delta_e_colours()(np.linspace(0, 1, 64))[:, :3].T ** 2.2
    assert (np.diff(lightness) > 0).all()  # more difference is always lighter


def test_delta_e_figure_states_its_scale(content):
    figure = delta_e_figure(content.comparison)
    bar = figure.axes[1]
    assert bar.get_xlim()[1] == delta_e_ceiling(content.comparison)
    assert {label.get_text() for label in bar.get_xticklabels()} >= {
        "0",
        f"{delta_e_ceiling(content.comparison):g}",
    }


def test_a_photograph_and_its_composite_stand_side_by_side(sheet, content):
    before, after = np.zeros((20, 30, 3), np.uint8), np.full((20, 30, 3), 99, np.uint8)
    page = comparison_sheet(replace(content, composed=(before, after)))
    places = {
        int(image.get_array().max()): axes.get_position()
        for axes in page.axes
        for image in axes.images
        if image.get_array().shape == before.shape
    }
    assert places[0].x1 < places[99].x0
    assert places[0].y0 == pytest.approx(places[99].y0)
    assert page.get_size_inches()[1] > sheet.get_size_inches()[1] + 3
    assert {"Photograph", "Composite"} <= {text.get_text() for text in page.texts}
