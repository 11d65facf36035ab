"""What is written comes back as it was, for any content: by hypothesis."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from spectral_probe.files.capture import load_capture, save_capture
from spectral_probe.files.image_exr import read_channels, write_channels
from spectral_probe.model import BallSettings, CameraSettings, Capture, ViewSettings
from spectral_probe.render.plan_file import load_plan, save_plan
from spectral_probe.render_model import EmissionGroup, PassPlan, SwappableLayer
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.library import FAMILIES


def numbers(least: float, most: float):
    return st.floats(least, most, allow_nan=False, allow_infinity=False)


lengths = numbers(1e-3, 1e5)
pairs = st.tuples(numbers(-1e4, 1e4), numbers(-1e4, 1e4))


def maybe(strategy):
    return st.none() | strategy


cameras = st.builds(
    CameraSettings,
    model=maybe(st.text('Nikon 5100(PL)"\\', min_size=1)),
    focal_px=maybe(st.tuples(lengths, lengths)),
    focal_mm=maybe(lengths),
    sensor_width_mm=maybe(lengths),
    principal_px=maybe(pairs),
    distortion=st.tuples(*[numbers(-1, 1)] * 5),
    half_size=st.booleans(),
)
materials = st.sampled_from(["SUS304", "Ag", "no such metal"]) | st.dictionaries(
    st.sampled_from(["Fe", "Cr", "Ni"]), numbers(1e-3, 1), min_size=1
)


@st.composite
def views(draw):
    """A view of one to three photographs; names that are hard to write down among them."""
    names = draw(
        st.lists(st.text("ab 'é#[]=0.", min_size=1, max_size=8), min_size=1, max_size=3, unique=True)
    )
    per_photo = maybe(st.tuples(*[numbers(1e-6, 1e4)] * len(names)))
    return ViewSettings(
        photos=tuple(Path(f"photo {name}.dng") for name in names),
        azimuth_deg=draw(numbers(-360, 720)),
        elevation_deg=draw(numbers(-90, 90)),
        roll_deg=draw(numbers(-180, 180)),
        refine=draw(st.booleans()),
        exposures_s=draw(per_photo),
        iso=draw(per_photo),
        f_number=draw(per_photo),
        outline=draw(maybe(st.tuples(numbers(-1e3, 1e4), numbers(-1e3, 1e4), lengths))),
        ball_at=draw(maybe(pairs)),
        solve_exposures=draw(st.booleans()),
        snap_outline=draw(st.booleans()),
    )


@given(
    st.lists(views(), min_size=1, max_size=3),
    cameras,
    st.builds(BallSettings, radius_m=lengths, material=materials),
    st.lists(st.sampled_from(list(FAMILIES)), min_size=1, max_size=3, unique=True).map(tuple),
    st.sampled_from(["family", "paper", "automatic"]),
    st.sampled_from(["blend", "cut"]),
)
def test_captures_come_back(tmp_path: Path, seen, camera, ball, families, method, composition):
    here = tuple(replace(view, photos=tuple(tmp_path / photo for photo in view.photos)) for view in seen)
    for photo in (photo for view in here for photo in view.photos):
        photo.touch()
    capture = Capture(here, camera, ball, families, method, composition)
    save_capture(capture, tmp_path / "capture.toml")
    assert load_capture(tmp_path / "capture.toml") == capture


@given(st.integers(1, 5), st.integers(0, 9999), st.booleans(), st.text(max_size=20), maybe(numbers(0, 100)))
def test_plans_come_back_exactly(tmp_path: Path, passes, seed, in_layers, text, cost):
    random = np.random.default_rng(seed)
    length = len(WAVELENGTHS_NM)
    interpolation = random.normal(size=(passes, length)) if in_layers else None
    group = EmissionGroup("lamps 1", random.uniform(size=(3, length)), (text, "", "desk"))
    plan = PassPlan(
        kind="light-basis" if in_layers else "wavelength",
        wavelengths_nm=np.repeat(WAVELENGTHS_NM[:passes, None], 3, 1),
        reconstruction=random.normal(size=(passes, 3, length)),
        grid_nm=WAVELENGTHS_NM.copy(),
        sample_shares=random.uniform(0.1, 1, passes),
        references=(0,) * passes,
        light_sets=(0,) * passes,
        interpolation=interpolation,
        emission=(group,) if in_layers else (),
        predicted_de2000=None if cost is None else (cost / 3, cost),
        predicted_cost=cost,
        swappable=(SwappableLayer(text, 0, 2, random.uniform(size=length)),) if in_layers else (),
        notes=(text,),
        level=float(random.uniform(0.1, 10)),
    )
    save_plan(plan, tmp_path / "plan.json")
    found = load_plan(tmp_path / "plan.json")
    for item in fields(PassPlan):
        if item.name not in ("emission", "swappable"):
            np.testing.assert_array_equal(getattr(found, item.name), getattr(plan, item.name), item.name)
    for ours, theirs in zip(
        (*found.emission, *found.swappable), (*plan.emission, *plan.swappable), strict=True
    ):
        for item in fields(ours):
            np.testing.assert_array_equal(getattr(ours, item.name), getattr(theirs, item.name))


@given(
    st.lists(st.text("abcXYZ019 ._", min_size=1, max_size=20), min_size=1, max_size=5, unique=True),
    st.tuples(st.integers(1, 40), st.integers(1, 40)),
    st.sampled_from([np.float16, np.float32, np.uint32]),
    st.integers(0, 99),
)
def test_channels_come_back_to_the_bit(tmp_path: Path, names, shape, kind, seed):
    random = np.random.default_rng(seed)
    written = {name: (100 * random.normal(size=shape)).__abs__().astype(kind) for name in names}
    write_channels(tmp_path / "a.exr", written)
    found, _ = read_channels(tmp_path / "a.exr")
    assert set(found) == set(written)
    for name, plane in written.items():
        np.testing.assert_array_equal(found[name], plane)
