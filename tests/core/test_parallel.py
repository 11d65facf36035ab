"""Work in threads."""

import numpy as np
import pytest

from spectral_probe import parallel


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("transposed", [(False, False), (False, True), (True, False), (True, True)])
def test_products_are_the_librarys(kind, transposed):
    rng = np.random.default_rng(1)
    matrix, columns = rng.random((61, 12)).astype(kind), rng.random((12, 3001)).astype(kind)
    if transposed[0]:
        matrix = np.asfortranarray(matrix)
    if transposed[1]:
        columns = np.asfortranarray(columns)
    found = parallel.product(matrix, columns)
    assert found.dtype == kind
    np.testing.assert_allclose(found, matrix.astype(float) @ columns, rtol=1e-5)


def test_no_product_is_asked_of_two_transposed_matrices(monkeypatch):
    """Two threads that ask OpenBLAS 0.3.34 for such products at once may get wrong numbers, or die."""
    rng = np.random.default_rng(1)
    asked = []

    def matmul(first, second, **further):
        asked.append(first.flags.c_contiguous)
        return original(first, second, **further)

    original = np.matmul
    monkeypatch.setattr(np, "matmul", matmul)
    parallel.product(rng.random((12, 61)).astype(np.float32).T, rng.random((3001, 12)).astype(np.float32).T)
    assert asked
    assert all(asked)
