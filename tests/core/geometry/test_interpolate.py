import numpy as np
import pytest

from spectral_probe.geometry.interpolate import bilinear

RNG = np.random.default_rng(4)


@pytest.mark.parametrize("shape", [(7,), (3, 5), (40000,), (2, 3, 4), (33000, 1), (0,)])
def test_places_of_any_shape(shape):
    image = RNG.random((20, 30, 3)).astype(np.float32)
    column, row = RNG.uniform(0, 29, shape), RNG.uniform(0, 19, shape)
    left, top = np.minimum(column.astype(int), 28), np.minimum(row.astype(int), 18)
    x, y = (column - left)[..., None], (row - top)[..., None]
    expected = (1 - y) * ((1 - x) * image[top, left] + x * image[top, left + 1]) + y * (
        (1 - x) * image[top + 1, left] + x * image[top + 1, left + 1]
    )
    found = bilinear(image, column.astype(np.float32), row.astype(np.float32))
    assert found.shape == (*shape, 3)
    assert np.abs(found - expected).max(initial=0.0) < 1e-5


def test_the_edge_is_repeated_and_a_single_channel_has_no_axis():
    image = np.array([[1.0, 2.0]], np.float32)
    found = bilinear(image, np.array([-5.0, 0.25, 9.0]), np.zeros(3))
    assert found.tolist() == [1.0, 1.25, 2.0]
