import numpy as np
import pytest

from spectral_probe.figures.chromaticity import ChromaticityShift, chromaticity_figure, shifts_of
from spectral_probe.figures.diagram import WHOLE_DIAGRAM, close_up_limits
from spectral_probe.render.compare import compare_images
from spectral_probe.spectra.colorimetry import white_xyz

METALS = (
    ChromaticityShift("gold", (0.3820, 0.3895), (0.3663, 0.3794)),
    ChromaticityShift("silver", (0.3134, 0.3300), (0.3132, 0.3298)),
    ChromaticityShift("copper", (0.3560, 0.3453), (0.3434, 0.3380)),
)


def test_points_and_arrows_are_where_the_numbers_say():
    axes = chromaticity_figure(METALS).axes[0]
    drawn = {
        (round(float(line.get_xdata()[0]), 4), round(float(line.get_ydata()[0]), 4))
        for line in axes.lines
        if line.get_marker() == "o" and len(line.get_xdata()) == 1
    }
    for shift in METALS:
        assert shift.xy_spectral in drawn
        assert shift.xy_rgb in drawn
    arrows = [text for text in axes.texts if getattr(text, "arrow_patch", None) is not None]
    assert [(text.xyann, text.xy) for text in arrows] == [
        (shift.xy_spectral, shift.xy_rgb) for shift in METALS
    ]
    assert {"gold", "silver", "copper"} <= {text.get_text() for text in axes.texts}


def test_close_up_holds_every_point_and_its_aspect():
    points = np.array([point for shift in METALS for point in (shift.xy_spectral, shift.xy_rgb)])
    x0, x1, y0, y1 = close_up_limits(points, 1.5)
    assert x0 < points[:, 0].min()
    assert points[:, 0].max() < x1
    assert y0 < points[:, 1].min()
    assert points[:, 1].max() < y1
    assert (y1 - y0) / (x1 - x0) == pytest.approx(1.5)
    axes = chromaticity_figure(METALS).axes[0]
    assert axes.get_xlim()[1] - axes.get_xlim()[0] < 0.2
    assert len(axes.child_axes) == 1  # the whole diagram in a corner


def test_far_apart_points_get_the_whole_diagram():
    axes = chromaticity_figure(
        [ChromaticityShift("red", (0.65, 0.33)), ChromaticityShift("blue", (0.16, 0.1))]
    ).axes[0]
    assert (*axes.get_xlim(), *axes.get_ylim()) == pytest.approx(WHOLE_DIAGRAM)
    assert not axes.child_axes


def test_shifts_of_a_comparison():
    image = np.ones((4, 4, 3)) * white_xyz()
    left = np.zeros((4, 4), bool)
    left[:, :2] = True
    comparison = compare_images(image, image * (1.1, 1, 1), object_masks={"left": left})
    (shift,) = shifts_of(comparison)
    assert (shift.name, shift.xy_rgb) == ("left", comparison.objects[0].xy_rgb)
    (whole,) = shifts_of(compare_images(image, image))
    assert whole.name == "image"


def test_names_of_close_objects_do_not_cover_each_other():
    crowd = [ChromaticityShift(f"ball {n}", (0.35 + 0.0004 * n, 0.34)) for n in range(6)]
    figure = chromaticity_figure(crowd)
    renderer = figure.canvas.get_renderer()
    names = [
        text.get_window_extent(renderer)
        for text in figure.axes[0].texts
        if text.get_text().startswith("ball")
    ]
    assert len(names) == 6
    assert not any(a.overlaps(b) for n, a in enumerate(names) for b in names[:n])
    assert all(name.x1 <= figure.bbox.width for name in names)
