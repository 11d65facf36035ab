"""Light layers beside the frames: exactly as they were found, or not at all."""

import numpy as np
import pytest

from spectral_probe.render.light_file import load_light_sets, save_light_sets
from spectral_probe.render_model import LightLayers, LightSet
from spectral_probe.spectra.grid import WAVELENGTHS_NM


@pytest.fixture
def sets():
    random = np.random.default_rng(7)
    return [
        LightSet(
            LightLayers(
                random.random((4, 8, 3)).astype(np.float32), random.normal(size=(3, 61)), WAVELENGTHS_NM, 0.01
            )
        )
        for _ in range(2)
    ]


def test_bits_come_back(sets, tmp_path):
    name = save_light_sets(sets, tmp_path / "light")
    found = load_light_sets(tmp_path / "light", name)
    assert len(found) == 2
    for kept, original in zip(found, sets, strict=True):
        np.testing.assert_array_equal(kept.layers.weights, original.layers.weights)
        np.testing.assert_array_equal(kept.layers.spectra, original.layers.spectra)
        assert kept.layers.residual == 0.01


def test_the_same_light_is_one_file(sets, tmp_path):
    name = save_light_sets(sets, tmp_path)
    before = [(path.name, path.stat().st_mtime_ns) for path in tmp_path.iterdir()]
    assert save_light_sets(sets, tmp_path) == name
    assert [(path.name, path.stat().st_mtime_ns) for path in tmp_path.iterdir()] == before
    assert save_light_sets(sets[:1], tmp_path) != name


@pytest.mark.parametrize("where", [0.3, 0.7, 0.95])
def test_damage_is_seen_and_mended(sets, tmp_path, where):
    name = save_light_sets(sets, tmp_path)
    path = tmp_path / f"{name}.exr"
    content = bytearray(path.read_bytes())
    content[int(where * len(content))] ^= 0x10
    path.write_bytes(content)
    assert load_light_sets(tmp_path, name) is None
    assert save_light_sets(sets, tmp_path) == name
    assert load_light_sets(tmp_path, name) is not None


def test_nothing_is_found_where_nothing_is(tmp_path):
    assert load_light_sets(tmp_path / "light", "0" * 32) is None
