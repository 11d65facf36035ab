"""probe.exr gives back what was written, to the bit, and says clearly what is wrong with a damaged one."""

import json

import numpy as np
import OpenEXR
import pytest

from spectral_probe.errors import FileFormatError
from spectral_probe.files.image_exr import read_channels, write_channels
from spectral_probe.files.probe_exr import read_probe, write_probe
from spectral_probe.model import Edit, SpectralPanorama
from spectral_probe.spectra.edits import apply_edit, glass_edit, lamp_edit, remove_all_edits, remove_edit
from spectral_probe.spectra.grid import WAVELENGTHS_NM

HEIGHT, WIDTH = 24, 48


@pytest.fixture(params=[(3, 1, True), (12, 3, False)], ids=["K3 B1", "K12 B3"])
def panorama(request):
    count, bases, has_error = request.param
    rng = np.random.default_rng(11)
    weights = rng.standard_normal((HEIGHT, WIDTH, count)).astype(np.float32)
    weights[0, 0] = np.finfo(np.float32).smallest_subnormal
    weights[0, 1] = [-0.0, np.finfo(np.float32).max, *np.finfo(np.float32).tiny * np.ones(count - 2)]
    spectra = rng.standard_normal((bases, count, 61))
    spectra[0, 0, :4] = [5e-324, 1 / 3, -0.0, np.nextafter(1, 2)]
    return SpectralPanorama(
        weights,
        spectra,
        rng.integers(0, bases, (HEIGHT, WIDTH)).astype(np.uint8),
        WAVELENGTHS_NM,
        rng.random((HEIGHT, WIDTH)) < 0.8,
        rng.random((HEIGHT, WIDTH)).astype(np.float32),
        {"camera": 'Kamera "Ä" \\ 測定 \U0001f4a1', "ball": "SUS304\nzwei"},
        rng.random((HEIGHT, WIDTH)).astype(np.float32) if has_error else None,
        further={"recovery": {"prior": [0.1, 1e-300, None], "names": ["π"]}, "later": 3},
    )


def assert_same(a, b):
    for name in ("weights", "bases", "basis_index", "wavelengths_nm", "valid", "confidence"):
        first, second = getattr(a, name), getattr(b, name)
        assert first.dtype == second.dtype
        assert first.shape == second.shape
        assert first.tobytes() == second.tobytes(), name
    errors = (a.direction_error_rad, b.direction_error_rad)
    assert (errors[0] is None) == (errors[1] is None)
    assert errors[0] is None or errors[0].tobytes() == errors[1].tobytes()
    assert a.provenance == b.provenance
    assert a.further == b.further
    assert a.derived_bases == b.derived_bases
    assert len(a.edits) == len(b.edits)
    for first, second in zip(a.edits, b.edits, strict=True):
        assert (first.kind, first.name, first.region, first.keeps) == (
            second.kind,
            second.name,
            second.region,
            second.keeps,
        )
        assert first.spectrum.tobytes() == second.spectrum.tobytes()


def edited(panorama):
    rng = np.random.default_rng(5)
    for edit in (
        glass_edit(panorama, "red", "vitrail é"),
        lamp_edit(panorama, "LED-B3", "lamp", "power"),
        glass_edit(panorama, "green", "all"),
    ):
        panorama = apply_edit(panorama, edit, rng.random((HEIGHT, WIDTH)) < 0.5)
    return panorama


@pytest.mark.parametrize("change", [lambda panorama: panorama, edited], ids=["plain", "edited"])
def test_what_is_read_is_what_was_written_to_the_bit(panorama, change, tmp_path):
    panorama = change(panorama)
    write_probe(tmp_path / "a.exr", panorama)
    read = read_probe(tmp_path / "a.exr")
    assert_same(read, panorama)
    write_probe(tmp_path / "b.exr", read)
    assert (tmp_path / "a.exr").read_bytes() == (tmp_path / "b.exr").read_bytes()


def test_edits_taken_back_from_a_file_leave_the_original_to_the_bit(panorama, tmp_path):
    write_probe(tmp_path / "original.exr", panorama)
    write_probe(tmp_path / "edited.exr", edited(panorama))
    left = read_probe(tmp_path / "edited.exr")
    for number in (1, 0, 0):
        write_probe(tmp_path / "left.exr", remove_edit(left, number))
        left = read_probe(tmp_path / "left.exr")
    assert_same(left, panorama)
    assert (tmp_path / "left.exr").read_bytes() == (tmp_path / "original.exr").read_bytes()


def test_a_probe_with_as_many_bases_as_there_can_be(tmp_path):
    count = 256
    one = np.ones((16, 16), np.float32)
    panorama = SpectralPanorama(
        np.ones((16, 16, 12), np.float32),
        np.random.default_rng(2).standard_normal((count, 12, 61)),
        np.arange(256, dtype=np.uint8).reshape(16, 16),
        WAVELENGTHS_NM,
        one > 0,
        one,
    )
    write_probe(tmp_path / "a.exr", panorama)
    assert_same(read_probe(tmp_path / "a.exr"), panorama)


def rewritten(path, change_header=None, change_channels=None):
    """A probe file with its header or its channels changed."""
    channels, header = read_channels(path)
    data = json.loads(header["spectralProbe"])
    if change_header:
        change_header(data)
    channels = {name: np.array(values) for name, values in channels.items()}
    if change_channels:
        change_channels(channels)
    write_channels(path, channels, {"spectralProbe": json.dumps(data)})
    return path


def test_probes_without_the_later_entries_are_read(panorama, tmp_path):
    write_probe(tmp_path / "a.exr", panorama)

    def older(data):
        for entry in ("edits", "derived_bases", "recovery", "later", "provenance"):
            del data[entry]

    read = read_probe(rewritten(tmp_path / "a.exr", older))
    assert read.edits == read.derived_bases == ()
    assert read.provenance == read.further == {}
    assert read.bases.tobytes() == panorama.bases.tobytes()
    assert_same(remove_all_edits(read), read)


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: data.pop("bases"),
        lambda data: data.update(bases=[[1, 2]]),
        lambda data: data.update(bases="none"),
        lambda data: data["bases"][0][0].__setitem__(0, float("nan")),
        lambda data: data.update(wavelengths_nm=[400, 700]),
        lambda data: data.update(edits=3),
        lambda data: data.update(provenance=[1]),
        lambda data: data["edits"][0].pop("spectrum"),
        lambda data: data["edits"][0].update(kind="magic"),
        lambda data: data["edits"][0].update(spectrum=[1.0]),
        lambda data: data["edits"].pop(),
        lambda data: data.update(derived_bases=[[0, 0.5]]),
        lambda data: data.update(derived_bases=[[0]]),
        lambda data: data.update(derived_bases=[[200, 0]]),
        lambda data: data.update(derived_bases=[[0, 0]] * 200),
    ],
)
def test_damaged_headers(panorama, damage, tmp_path):
    write_probe(tmp_path / "a.exr", edited(panorama))
    with pytest.raises(FileFormatError, match=r"^a\.exr is a damaged probe\. Build it again"):
        read_probe(rewritten(tmp_path / "a.exr", damage))


@pytest.mark.parametrize(
    "damage",
    [
        lambda channels: channels.pop("eps.1"),
        lambda channels: channels.pop("valid"),
        lambda channels: channels["basis_index"].__setitem__((0, 0), 300),
        lambda channels: channels["basis_index"].__setitem__((0, 0), -1),
        lambda channels: channels["basis_index"].__setitem__((0, 0), np.nan),
    ],
)
def test_damaged_channels(panorama, damage, tmp_path):
    write_probe(tmp_path / "a.exr", panorama)
    with pytest.raises(FileFormatError, match=r"^a\.exr is a damaged probe\."):
        read_probe(rewritten(tmp_path / "a.exr", change_channels=damage))


@pytest.mark.parametrize("header", ["[1, 2]", "3", "{", "null"])
def test_headers_of_another_kind(panorama, header, tmp_path):
    write_probe(tmp_path / "a.exr", panorama)
    channels, _ = read_channels(tmp_path / "a.exr")
    write_channels(
        tmp_path / "a.exr", {name: np.array(v) for name, v in channels.items()}, {"spectralProbe": header}
    )
    with pytest.raises(FileFormatError, match=r"a\.exr was not written as a probe\.exr"):
        read_probe(tmp_path / "a.exr")


def test_a_file_cut_short(panorama, tmp_path):
    write_probe(tmp_path / "a.exr", panorama)
    whole = (tmp_path / "a.exr").read_bytes()
    for share in (0.1, 0.5, 0.99):
        (tmp_path / "a.exr").write_bytes(whole[: int(share * len(whole))])
        with pytest.raises(FileFormatError, match=r"^a\.exr .*cut short"):
            read_probe(tmp_path / "a.exr")


def test_the_edits_are_in_the_header_for_others_to_read(panorama, tmp_path):
    write_probe(tmp_path / "a.exr", edited(panorama))
    header = json.loads(OpenEXR.File(str(tmp_path / "a.exr"), header_only=True).header()["spectralProbe"])
    assert [entry["name"] for entry in header["edits"]] == ["red", "LED-B3", "green"]
    assert header["version"] == 1
    assert isinstance(panorama.edits, tuple)
    assert Edit("glass", "a", "b", np.ones(61)).keeps == "luminance"
