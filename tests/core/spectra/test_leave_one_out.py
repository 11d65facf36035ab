"""The benchmark of lights the program has not seen, on every seventeenth light: what README states must roughly hold of them."""

import importlib.util
import sys

import pytest

from spectral_probe.spectra.camera import camera_sensitivities

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def benchmark(project_root):
    spec = importlib.util.spec_from_file_location(
        "leave_one_out_benchmark", project_root / "benchmarks" / "spectral_recovery.py"
    )
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules[spec.name]


@pytest.fixture(scope="module")
def table(benchmark):
    camera = camera_sensitivities("Nikon 5100 (NPL)")
    return {row.name: benchmark.measure(row, camera, 0.005, 1, every=17) for row in benchmark.ROWS}


# Measured with all lights: 0.833, 0.930, 0.9992, 0.884, 0.928 and 0.953. A seventeenth of them differs by up to 0.02.
@pytest.mark.parametrize(
    ("row", "goodness", "relative_rmse", "metals"),
    [
        ("paper (PCA-3 of all)", 0.77, 0.75, 8.0),
        ("family told", 0.89, 0.36, 6.0),
        ("incandescent + daylight", 0.9985, 0.06, 1.5),
        ("automatic", 0.85, 0.50, 6.5),
        ("automatic, 6 channels", 0.88, 0.39, 5.0),
        ("automatic, 9 channels", 0.92, 0.34, 4.5),
    ],
)
def test_lights_that_were_not_seen_come_back(table, row, goodness, relative_rmse, metals):
    assert table[row]["gfc"] > goodness
    assert table[row]["relative_rmse"] < relative_rmse
    assert table[row]["metals"] < metals


def test_more_knowledge_is_better(table):
    """The paper's three components, all families, a second and a third photo set, the family told."""
    order = ["paper (PCA-3 of all)", "automatic", "automatic, 6 channels", "automatic, 9 channels"]
    goodness = [table[row]["gfc"] for row in order]
    assert goodness == sorted(goodness)
    assert table["family told"]["gfc"] > table["automatic"]["gfc"]


def test_the_stated_band_holds_the_true_spectrum(table):
    """95 % is stated; over all lights 94.2, 97.4, 93.1 and 95.1 % hold, with more scatter over a seventeenth of them."""
    rows = [
        table[row] for row in ("family told", "incandescent + daylight", "automatic", "automatic, 6 channels")
    ]
    assert min(row["coverage"] for row in rows) > 0.87
    assert 0.90 <= sum(row["coverage"] for row in rows) / len(rows) <= 0.99
