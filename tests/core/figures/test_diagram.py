import numpy as np
import pytest

from spectral_probe.figures.diagram import (
    KELVINS,
    WHOLE_DIAGRAM,
    close_up_limits,
    diagram_colours,
    draw_diagram,
    planckian_locus,
    spectral_locus,
    with_d65,
)
from spectral_probe.figures.style import axes_at, house_style, new_figure


def test_locus_has_the_tabulated_chromaticities():
    locus = spectral_locus()  # CIE 15, table of the 1931 observer
    np.testing.assert_allclose(locus[460 - 390], (0.1440, 0.0297), atol=1e-4)
    np.testing.assert_allclose(locus[600 - 390], (0.6270, 0.3725), atol=1e-4)


def test_black_bodies_lie_on_the_planckian_locus():
    np.testing.assert_allclose(
        planckian_locus(np.array([2856.0, 6500.0])), [(0.4476, 0.4074), (0.3135, 0.3237)], atol=6e-4
    )


def test_colours_of_the_diagram():
    colours = diagram_colours((0.1, 0.7, 0.0, 0.8), 61).astype(int)  # 0.01 in x, 0.0133 in y a pixel
    assert colours[26, 55].argmax() == 0  # x 0.65, y 0.35
    assert colours[50, 12].argmax() == 1  # x 0.22, y 0.67
    assert colours[5, 5].argmax() == 2  # x 0.15, y 0.07
    assert np.ptp(colours[25, 21]) < 12  # near white
    assert colours.min() > 150  # pale enough for lines and letters


@pytest.fixture
def diagram_of():
    """A diagram about points, all of them named, and its axes."""

    def draw(points, names=None):
        figure = new_figure(5.0, 5.0)
        axes = axes_at(figure, 0.5, 0.5, 4.0, 4.0)
        with house_style():
            diagram = draw_diagram(axes, with_d65(np.array(points)))
            for name, xy in zip(names or (), points, strict=False):
                diagram.labels.name(name, xy)
            diagram.number_ticks()
        return axes, diagram

    return draw


def texts_of(axes):
    renderer = axes.get_figure().canvas.get_renderer()
    return {text.get_text(): text.get_window_extent(renderer) for text in axes.texts if text.get_text()}


def test_no_two_names_or_numbers_cover_each_other(diagram_of):
    points = [
        (0.43, 0.405),
        (0.437, 0.404),
        (0.372, 0.367),
        (0.405, 0.391),
        (0.31, 0.33),
    ]  # on and beside ticks
    axes, _ = diagram_of(points, ["Gold Pedestal", "Lamp", "Silver Ball", "Window", "Sky"])
    boxes = texts_of(axes)
    assert {"Gold Pedestal", "Lamp", "Silver Ball", "Window", "Sky", "D65"} <= set(boxes)
    covered = [(a, b) for a in boxes for b in boxes if a < b and boxes[a].overlaps(boxes[b])]
    assert not covered
    for box in boxes.values():
        assert axes.bbox.x0 <= box.x0
        assert box.x1 <= axes.bbox.x1
    marks = axes.transData.transform(points)
    assert not [name for name, box in boxes.items() for x, y in marks if box.contains(x, y)]


def test_a_number_without_room_is_left_out(diagram_of):
    kelvin = planckian_locus(np.array([3000.0]))[0]
    crowd = [tuple(kelvin + step * np.array([0.002, 0.001])) for step in (-1.5, -0.5, 0.5, 1.5)]
    axes, _ = diagram_of([*crowd, (0.40, 0.36)], [f"ball number {n}" for n in range(4)])
    numbered = {text.get_text() for text in axes.texts}
    assert "3000 K" not in numbered
    alone, _ = diagram_of([tuple(kelvin), (0.40, 0.36)])
    assert "3000 K" in {text.get_text() for text in alone.texts}


def test_the_whole_diagram_marks_few_temperatures(diagram_of):
    axes, diagram = diagram_of([(0.65, 0.33), (0.16, 0.1)])
    assert diagram.limits == WHOLE_DIAGRAM
    assert len(diagram.ticks) == len(KELVINS[::3])
    assert not axes.child_axes


def test_limits_have_the_aspect_asked_for():
    x0, x1, y0, y1 = close_up_limits(np.array([[0.3, 0.3], [0.4, 0.35]]), 1.5)
    assert (y1 - y0) / (x1 - x0) == pytest.approx(1.5)
