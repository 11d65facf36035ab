"""The sample capture of the gym: complete, small, readable, and consistent with how it says it was made."""

import importlib
import importlib.util
import json
import sys
import tomllib
from types import ModuleType

import numpy as np
import pytest
import rawpy

from spectral_probe.files.capture import load_capture

LIMIT_BYTES = 6_000_000
FILE_LIMIT_BYTES = 5_000_000
VIEWS, EXPOSURES, SIZE_PX = 3, 3, 480
BLACK, WHITE = 600, 15892


@pytest.fixture(scope="module")
def gym(project_root):
    return project_root / "sample_scenes" / "gym"


@pytest.fixture(scope="module")
def builder(gym):
    """The modules of the sample's builder that need no Blender, by name."""
    root = gym / "builder"
    spec = importlib.util.spec_from_file_location(
        "gym_builder", root / "__init__.py", submodule_search_locations=[str(root)]
    )
    package = importlib.util.module_from_spec(spec)
    sys.modules["gym_builder"] = package
    spec.loader.exec_module(package)

    def module(name: str) -> ModuleType:
        return importlib.import_module(f"gym_builder.{name}")

    yield module
    for name in [name for name in sys.modules if name.startswith("gym_builder")]:
        del sys.modules[name]


def read_levels(path):
    with rawpy.imread(str(path)) as raw:
        return raw.raw_image_visible.astype(float).copy()


def read_csv(path):
    rows = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    assert rows[0].startswith("wavelength_nm,radiance")
    return np.array([[float(v) for v in row.split(",")] for row in rows[1:]]).T


def test_it_is_small(gym):
    files = [path for path in gym.rglob("*") if path.is_file() and "__pycache__" not in path.parts]
    assert sum(path.stat().st_size for path in files) < LIMIT_BYTES
    assert max(path.stat().st_size for path in files) < FILE_LIMIT_BYTES


def test_every_data_file_has_a_passport(gym):
    passports = tomllib.loads((gym / "SOURCES.toml").read_text(encoding="utf-8"))
    described = {name for entry in passports.values() for name in entry["files"]}
    data = {
        p.relative_to(gym).as_posix()
        for s in ("dng", "csv", "npz", "json", "jpg")
        for p in gym.rglob(f"*.{s}")
    }
    assert described == data
    for name, entry in passports.items():
        assert {"quantity", "unit", "licence", "source"} <= set(entry), name


def test_the_capture_loads_and_its_photographs_exist(gym):
    capture = load_capture(gym / "capture.toml")
    assert [view.azimuth_deg for view in capture.views] == [0, 120, 240]
    assert all(photo.is_file() for view in capture.views for photo in view.photos)
    assert capture.ball.radius_m == 0.05
    assert dict(capture.ball.material) == {"Fe": 0.74, "Cr": 0.18, "Ni": 0.08}


def test_the_capture_states_the_camera_it_was_rendered_with(gym, builder):
    layout = builder("layout")
    camera = load_capture(gym / "capture.toml").camera
    assert np.allclose(camera.focal_px, layout.FOCAL_PX, rtol=1e-6)
    assert tuple(camera.principal_px) == layout.PRINCIPAL_PX
    assert camera.model == builder("spectra").CAMERA


@pytest.mark.parametrize("view", range(VIEWS))
def test_libraw_reads_each_photograph_as_of_a_camera(gym, view):
    for exposure in range(EXPOSURES):
        with rawpy.imread(str(gym / f"view{view}_{exposure}.dng")) as raw:
            assert raw.raw_image_visible.shape == (SIZE_PX, SIZE_PX)
            assert raw.color_desc == b"RGBG"
            assert raw.raw_pattern.tolist() == [[0, 1], [3, 2]]
            assert raw.black_level_per_channel == [BLACK] * 4
            assert raw.white_level == WHITE
            assert raw.raw_image_visible.max() <= WHITE


@pytest.mark.parametrize("view", range(VIEWS))
def test_the_bracket_spans_the_light(gym, view):
    short, _, long = (read_levels(gym / f"view{view}_{i}.dng") for i in range(EXPOSURES))
    assert (short >= WHITE).mean() < 1e-3, "lamps and windows are clipped even in the shortest exposure"
    assert BLACK + 0.15 * (WHITE - BLACK) < np.median(long) < WHITE, (
        "the hall is not well exposed in the longest"
    )


def test_exposures_are_linear_in_time(gym):
    short, middle = (read_levels(gym / f"view0_{i}.dng") - BLACK for i in (0, 1))
    clear = (middle > 1500) & (middle < 12000)
    assert clear.sum() > 1000
    assert middle[clear].sum() / short[clear].sum() == pytest.approx(8.0, rel=0.01)


def test_noise_is_that_of_photons_and_reading(gym, builder):
    """The wainscot behind the ball is smooth: neighbours of one colour differ by noise. Variance = gain * signal + read noise."""
    photograph = builder("photograph")
    gain = (WHITE - BLACK) / photograph.FULL_WELL_ELECTRONS
    green = (read_levels(gym / "view0_1.dng") - BLACK)[0:40:2, 1:161:2]
    measured = np.diff(green, axis=0).var() / 2
    expected = gain * green.mean() + (gain * photograph.READ_NOISE_ELECTRONS) ** 2
    assert 0.8 < measured / expected < 1.6


def test_the_ball_is_whole_in_the_frame(builder):
    layout = builder("layout")
    sine = layout.BALL_RADIUS_M / layout.CAMERA_DISTANCE_M
    radius_px = layout.FOCAL_PX * sine / np.sqrt(1 - sine**2)
    margins = [min(c, layout.PICTURE_PX - c) - radius_px for c in layout.PRINCIPAL_PX]
    assert min(margins) > 20


def test_the_lamp_is_warm_and_the_window_is_day(gym, builder):
    spectra = builder("spectra")
    functions = spectra.colour_matching_functions()
    chromaticities = {}
    for name, expected in (("lamp", spectra.lamp_radiance()), ("window", spectra.window_radiance())):
        wavelengths_nm, radiance = read_csv(gym / "truth" / f"{name}.csv")
        assert np.array_equal(wavelengths_nm, spectra.WAVELENGTHS_NM)
        assert np.allclose(radiance, expected, rtol=1e-5)
        xyz = radiance @ functions
        chromaticities[name] = xyz[:2] / xyz.sum()
    assert np.allclose(chromaticities["lamp"], (0.4507, 0.4080), atol=0.003)
    assert np.allclose(chromaticities["window"], (0.319, 0.337), atol=0.012)


def test_the_truth_shows_each_lamp_and_window_where_the_scene_says(gym, builder):
    """At the stated direction the panorama holds the stated spectrum, windows up to their stated factor of 0.7 to 1."""
    truth = builder("truth")
    panorama = truth.expand_panorama(gym / "truth" / "panorama.npz")
    height, width, _ = panorama.shape
    scene = json.loads((gym / "truth" / "scene.json").read_text(encoding="utf-8"))
    for kind, darkest in (("lamp", 0.99), ("window", 0.65)):
        _, radiance = read_csv(gym / "truth" / f"{kind}.csv")
        at = scene["recommended"][kind]
        row = int((90 - at["elevation_deg"]) / 180 * height)
        column = int((0.5 + at["bearing_deg"] / 360) % 1 * width)
        found = panorama[row, column]
        factor = float(found @ radiance / (radiance @ radiance))
        assert darkest < factor < 1.01, kind
        assert np.abs(found - factor * radiance).max() < 0.005 * radiance.max(), kind


def test_the_truth_shows_every_lamp_in_its_direction(gym, builder):
    """The luminance-weighted centre of each lamp's patch, within a quarter of a pixel (1.4 degrees)."""
    truth, spectra = builder("truth"), builder("spectra")
    panorama = truth.expand_panorama(gym / "truth" / "panorama.npz")
    height, width, _ = panorama.shape
    warm = panorama[..., 50] > 2 * panorama[..., 10]
    light = np.where(warm & (spectra.luminance(panorama) > 2000), spectra.luminance(panorama), 0.0)
    rows, columns = np.mgrid[:height, :width]
    bearing, elevation = (
        (columns + 0.5) / width * 2 * np.pi - np.pi,
        np.pi / 2 - (rows + 0.5) / height * np.pi,
    )
    across = np.cos(elevation)
    rays = np.stack([across * np.sin(bearing), across * np.cos(bearing), np.sin(elevation)], -1)
    errors = []
    for lamp in json.loads((gym / "truth" / "scene.json").read_text(encoding="utf-8"))["lamps"]:
        towards = np.array(lamp["at_m"]) - builder("layout").BALL_AT
        towards /= np.linalg.norm(towards)
        weight = np.where(rays @ towards > np.cos(np.radians(7)), light * across, 0.0)
        centre = (rays * weight[..., None]).sum((0, 1))
        errors.append(np.degrees(np.arccos(np.clip(centre @ towards / np.linalg.norm(centre), -1, 1))))
    assert np.median(errors) < 0.35
    assert max(errors) < 0.8


def test_the_truth_is_a_panorama_of_light(gym, builder):
    truth = builder("truth")
    panorama = truth.expand_panorama(gym / "truth" / "panorama.npz")
    assert panorama.shape == (128, 256, 61)
    assert np.isfinite(panorama).all()
    assert panorama.min() > -1e-4 * panorama.max()


def test_the_truth_expands_for_scoring(gym, builder, tmp_path):
    builder("truth").write_for_scoring(gym / "truth", tmp_path)
    with np.load(tmp_path / "truth.npz") as stored:
        assert stored["panorama"].dtype == np.float16
        assert stored["wavelengths"].shape == (61,)
    assert len(json.loads((tmp_path / "case.json").read_text(encoding="utf-8"))["lamps"]) == 12


def test_the_ball_follows_equation_11(builder):
    """Against the extension's own Fresnel code, written apart from the builder's."""
    from spectral_probe.spectra import metals

    spectra = builder("spectra")
    cosines = np.array([0.05, 0.3, 0.7, 1.0])
    assert np.allclose(
        spectra.ball_reflectance(cosines), metals.ball_reflectance(spectra.BALL_FRACTIONS, cosines), atol=2e-3
    )


def test_node_interpolation_keeps_cubics(builder):
    spectra = builder("spectra")
    cubic = np.polynomial.Polynomial([0.3, 0.1, -0.4, 0.2])
    at = (spectra.NODES_NM - 550) / 150
    assert np.allclose(spectra.node_interpolation() @ cubic(at), cubic((spectra.WAVELENGTHS_NM - 550) / 150))
