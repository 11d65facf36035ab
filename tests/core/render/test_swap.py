"""Lights of a finished render exchanged: the sum over stored transports equals a render with the other light."""

import argparse
import json

import numpy as np
import pytest

from spectral_probe.cli_swap import add_swappable_words, swappable_masks
from spectral_probe.errors import FileFormatError, RenderError, SpectralDataError
from spectral_probe.files.image_exr import read_channels, read_rgb, write_channels, write_rgb
from spectral_probe.model import SpectralPanorama, finish
from spectral_probe.render.outputs import picture_header, picture_rgb
from spectral_probe.render.plan_file import load_plan, save_plan
from spectral_probe.render.swap import Swap, light_names, spectrum_after, swap, swappable_layers
from spectral_probe.render_model import EmissionGroup, PassPlan, SwappableLayer
from spectral_probe.spectra.colorimetry import (
    colour_matching_functions,
    illuminant,
    spectra_to_xyz,
    xyz_to_rec709,
)
from spectral_probe.spectra.edits import lamp_spectrum
from spectral_probe.spectra.glass import glass_transmittance
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.white import parse_white
from spectral_probe.spectra.working_space import space_of_header
from spectral_probe.swapping import list_lights, swap_light

SIZE = (4, 5)
ACESCG = (0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767)
"""Chromaticities of red, green, blue and white."""

SETS = (0, 0, 1, 1, 1)


class Rendered:
    """A render of random transports: a world set that stays, a set with a window behind red glass (two layers), a lamp."""

    def __init__(self, folder):
        generator = np.random.default_rng(8)
        self.folder = folder
        self.recovered = generator.random((2, 61)) + 0.2
        self.spectra = np.zeros((2, 3, 61))
        self.spectra[0] = generator.random((3, 61))
        self.spectra[1, :2] = self.recovered * glass_transmittance("red")
        self.interpolation = np.zeros((5, 61))
        self.interpolation[:2] = generator.dirichlet(np.ones(2), size=61).T
        self.interpolation[2:] = generator.dirichlet(np.ones(3), size=61).T
        lamps = np.stack([illuminant("A") / 100, illuminant("FL2") / 10, np.zeros(61)])
        self.emission = EmissionGroup("lamps 1", lamps, ("", "desk", ""))
        self.world = generator.random((5, *SIZE, 3)).astype(np.float32)
        self.lamps = generator.random((5, *SIZE, 3)).astype(np.float32)
        self.plan = PassPlan(
            kind="light-basis",
            wavelengths_nm=np.repeat([[450.0], [560.0], [450.0], [550.0], [620.0]], 3, axis=1),
            reconstruction=self.interpolation[:, None] * self.spectra[list(SETS)],
            grid_nm=WAVELENGTHS_NM.copy(),
            sample_shares=np.ones(5),
            references=(0, 1, 2, 3, 4),
            light_sets=SETS,
            interpolation=self.interpolation,
            emission=(self.emission,),
            swappable=tuple(SwappableLayer("window", 1, k, self.recovered[k]) for k in range(2)),
        )
        self.write()

    def xyz(self, window=None, desk=None):
        """What a render would give with these spectra (2, 61) of the window and (61,) of the desk lamp."""
        spectra, lamps = self.spectra.copy(), self.emission.spectra.copy()
        if window is not None:
            spectra[1, :2] = window
        if desk is not None:
            lamps[1] = desk
        total = np.zeros((*SIZE, 61))
        for row, number in enumerate(SETS):
            total += self.world[row] @ (self.interpolation[row] * spectra[number])
            if number == 0:
                total += self.lamps[row] @ (self.interpolation[row] * lamps)
        return spectra_to_xyz(total)

    def write(self):
        save_plan(self.plan, self.folder / "plan.json")
        planes = {f"layer{k}.pass{p}": self.world[p, ..., k] for k in range(2) for p in (2, 3, 4)}
        planes |= {f"layer2.pass{p}": self.lamps[p, ..., 1] for p in (0, 1)}
        fixed = self.xyz(window=np.zeros((2, 61)), desk=np.zeros(61)).astype(np.float32)
        planes |= {f"fixed.{axis}": fixed[..., index] for index, axis in enumerate("XYZ")}
        write_channels(self.folder / "swappable.exr", planes)
        xyz = self.xyz().astype(np.float32)
        write_rgb(self.folder / "xyz.exr", xyz, "XYZ", {"comments": "tristimulus values"})
        rgb = xyz_to_rec709(xyz)
        alpha = np.full(SIZE, 0.5, np.float32)
        write_channels(
            self.folder / "image.exr", {**dict(zip("RGB", np.moveaxis(rgb, -1, 0), strict=True)), "A": alpha}
        )
        (self.folder / "report.json").write_text(json.dumps({"passes": 5, "warnings": []}))


@pytest.fixture
def rendered(tmp_path):
    return Rendered(tmp_path)


def test_the_lights_are_listed_in_the_order_of_their_layers(rendered):
    assert light_names(rendered.plan) == ("window", "desk")
    layers = swappable_layers(rendered.plan)
    np.testing.assert_allclose([layer.spectrum for layer in layers[:2]], rendered.spectra[1, :2], rtol=1e-12)
    assert finish(list_lights(rendered.folder)) == {
        "lights": {"window": "as rendered", "desk": "as rendered"}
    }


def test_the_picture_keeps_its_space_and_its_white(rendered):
    space, white = space_of_header({"chromaticities": ACESCG}, "image.exr"), parse_white("A")
    header = picture_header(space, white, "from XYZ") | {"comments": f"from XYZ; {white.note}; denoised"}
    rgb = picture_rgb(rendered.xyz(), space, white)
    write_channels(
        rendered.folder / "image.exr", dict(zip("RGB", np.moveaxis(rgb, -1, 0), strict=True)), header
    )
    finish(swap_light(rendered.folder, "window", glass="green"))
    channels, header = read_channels(rendered.folder / "image.exr")
    expected = picture_rgb(
        rendered.xyz(window=rendered.recovered * glass_transmittance("green")), space, white
    )
    np.testing.assert_allclose(np.stack([channels[c] for c in "RGB"], -1), expected, rtol=1e-4, atol=1e-5)
    assert space_of_header(header, "image.exr").name == "ACEScg"
    assert "ACEScg" in header["comments"]
    assert white.note in header["comments"]
    assert "denoised" not in header["comments"]


def test_another_glass_filters_the_light_behind_the_first(rendered):
    green = glass_transmittance("green")
    expected = rendered.xyz(window=rendered.recovered * green)
    np.testing.assert_allclose(swap(rendered.folder, "Window", green, "glass"), expected, rtol=1e-5)


@pytest.mark.parametrize("keeps", ["luminance", "power"])
def test_another_lamp_keeps_luminance_or_power(rendered, keeps):
    lamp = lamp_spectrum("HP1")
    kept = colour_matching_functions()[:, 1] if keeps == "luminance" else np.ones(61)
    before = rendered.emission.spectra[1]
    after = lamp * (before @ kept) / (lamp @ kept)
    expected = rendered.xyz(desk=after)
    np.testing.assert_allclose(swap(rendered.folder, "desk", lamp, "lamp", keeps), expected, rtol=1e-5)
    (desk,) = (layer for layer in swappable_layers(rendered.plan) if layer.name == "desk")
    np.testing.assert_allclose(spectrum_after(desk, Swap("lamp", "HP1", lamp, keeps)), after)


def test_swaps_add_up_and_are_taken_back(rendered):
    original = (rendered.folder / "xyz.exr").read_bytes()
    finish(swap_light(rendered.folder, "window", glass="green"))
    numbers = finish(swap_light(rendered.folder, "desk", lamp="HP1"))
    assert numbers["lights"] == {"window": "glass green", "desk": "lamp HP1"}
    lamp, before = lamp_spectrum("HP1"), rendered.emission.spectra[1]
    y_bar = colour_matching_functions()[:, 1]
    both = rendered.xyz(
        window=rendered.recovered * glass_transmittance("green"),
        desk=lamp * (before @ y_bar) / (lamp @ y_bar),
    )
    np.testing.assert_allclose(read_rgb(rendered.folder / "xyz.exr", ("X", "Y", "Z")), both, rtol=1e-5)
    channels, _ = read_channels(rendered.folder / "image.exr")
    np.testing.assert_allclose(channels["R"], xyz_to_rec709(both)[..., 0], rtol=1e-4, atol=1e-5)
    assert (channels["A"] == 0.5).all()
    assert json.loads((rendered.folder / "report.json").read_text())["lights"] == numbers["lights"]
    finish(swap_light(rendered.folder, "window"))
    finish(swap_light(rendered.folder, "desk"))
    assert (rendered.folder / "xyz.exr").read_bytes() != original  # other compression, but the same values
    np.testing.assert_allclose(
        read_rgb(rendered.folder / "xyz.exr", ("X", "Y", "Z")), rendered.xyz(), rtol=1e-5
    )


def test_another_folder_leaves_the_render_alone(rendered, tmp_path):
    before = {path.name: path.read_bytes() for path in rendered.folder.iterdir()}
    finish(swap_light(rendered.folder, "window", lamp="FL11", output=tmp_path / "other"))
    assert {path.name: path.read_bytes() for path in rendered.folder.iterdir() if path.is_file()} == before
    names = sorted(path.name for path in (tmp_path / "other").iterdir())
    assert names == ["image.exr", "report.json", "swaps.json", "xyz.exr"]


def test_what_there_is_not_is_named(rendered):
    with pytest.raises(RenderError, match=r'no swappable light "door" in this render\. It has window, desk'):
        finish(swap_light(rendered.folder, "door", lamp="A"))
    with pytest.raises(SpectralDataError, match="no lamp"):
        finish(swap_light(rendered.folder, "desk", lamp="no such lamp"))
    with pytest.raises(SpectralDataError, match="glass"):
        finish(swap_light(rendered.folder, "window", glass="no such glass"))


def test_a_render_without_swappable_lights_is_refused(rendered):
    from dataclasses import replace

    save_plan(replace(rendered.plan, swappable=(), emission=()), rendered.folder / "plan.json")
    with pytest.raises(RenderError, match="Nothing in this render can be exchanged"):
        finish(swap_light(rendered.folder, "window", lamp="A"))


def test_missing_or_foreign_transports_are_named(rendered):
    path = rendered.folder / "swappable.exr"
    channels, _ = read_channels(path)
    for damage in (
        {name: plane for name, plane in channels.items() if name != "layer1.pass3"},
        {**channels, "layer7.pass3": channels["layer1.pass3"]},
        {name: plane for name, plane in channels.items() if name != "fixed.Y"},
    ):
        write_channels(path, damage)
        with pytest.raises(FileFormatError, match="does not fit the plan"):
            finish(swap_light(rendered.folder, "window", lamp="A"))
    path.unlink()
    with pytest.raises(FileFormatError, match=r"swappable\.exr is missing"):
        finish(swap_light(rendered.folder, "window", lamp="A"))
    (rendered.folder / "swaps.json").write_text("{}")
    with pytest.raises(FileFormatError, match="is damaged"):
        finish(list_lights(rendered.folder))
    assert load_plan(rendered.folder / "plan.json").swappable


def test_the_verb_swaps_and_names_what_is_missing(rendered, capsys):
    from spectral_probe.cli import main

    assert main(["swap", str(rendered.folder), "--light", "desk", "--lamp", "FL11", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["lights"]["desk"] == "lamp FL11"
    assert main(["swap", str(rendered.folder), "--list"]) == 0
    assert "lamp FL11" in capsys.readouterr().out
    assert main(["swap", str(rendered.folder), "--lamp", "A"]) == 2
    assert "give --light NAME" in capsys.readouterr().err
    assert main(["swap", str(rendered.folder / "nowhere"), "--light", "desk", "--original"]) == 2
    assert "plan.json" in capsys.readouterr().err


def test_words_of_render_mark_regions(tmp_path, capsys):
    parser = argparse.ArgumentParser()
    add_swappable_words(parser)
    region = tmp_path / "window.json"
    region.write_text(json.dumps({"polygon_deg": [[-20, -20], [20, -20], [20, 20], [-20, 20]]}))
    size = (16, 32)
    panorama = SpectralPanorama(
        weights=np.ones((*size, 1), np.float32),
        bases=np.ones((1, 1, 61)),
        basis_index=np.zeros(size, np.uint8),
        wavelengths_nm=WAVELENGTHS_NM,
        valid=np.ones(size, bool),
        confidence=np.ones(size, np.float32),
    )
    assert swappable_masks(parser.parse_args([]), panorama) == {}
    masks = swappable_masks(parser.parse_args(["--swappable", f"window={region}"]), panorama)
    assert list(masks) == ["window"]
    assert 0 < masks["window"].mean() < 0.1
    twice = parser.parse_args(["--swappable", f"a={region}", "--swappable", f"a={region}"])
    with pytest.raises(RenderError, match="Two swappable regions"):
        swappable_masks(twice, panorama)
    with pytest.raises(SystemExit):
        parser.parse_args(["--swappable", "window"])
    assert "NAME=REGION.json" in capsys.readouterr().err
