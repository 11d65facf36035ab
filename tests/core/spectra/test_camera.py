import json

import numpy as np
import pytest

from spectral_probe.errors import SpectralDataError
from spectral_probe.spectra.camera import (
    REC709,
    camera_names,
    camera_sensitivities,
    cameras_in,
    gains_lost,
    gains_remark,
)
from spectral_probe.spectra.camera_names import LIBRARY_CAMERAS
from spectral_probe.spectra.colorimetry import illuminant
from spectral_probe.spectra.grid import WAVELENGTHS_NM


@pytest.mark.parametrize("name", camera_names())
def test_every_named_camera_has_three_channels_in_order(name):
    curves = camera_sensitivities(name)
    assert curves.shape == (61, 3)
    red, green, blue = WAVELENGTHS_NM[curves.argmax(0)]
    assert blue < green < red


def test_rec709_sees_d65_as_white():
    rgb = illuminant("D65") @ camera_sensitivities("Rec.709")
    assert rgb / rgb[1] == pytest.approx([1, 1, 1], abs=5e-3)  # 400-700 nm only


def test_unknown_camera_suggests_the_nearest():
    with pytest.raises(SpectralDataError, match=r'Did you mean "Nikon 5100 \(NPL\)"'):
        camera_sensitivities("Nikon D5100")


def write_csv(path, first, last):
    rows = [f"{nm},{nm / 1000},{(nm / 900) ** 2},{(800 - nm) / 800}" for nm in range(first, last + 1, 10)]
    path.write_text("# measured\nwavelength_nm,r,g,b\n" + "\n".join(rows))
    return path


def test_csv(tmp_path):
    curves = camera_sensitivities(file=write_csv(tmp_path / "mine.csv", 380, 780))
    assert np.allclose(curves[:, 0], WAVELENGTHS_NM / 1000)


def test_ampas_json_with_channels_in_another_order(tmp_path):
    table = {str(nm): [(800 - nm) / 800, (nm / 900) ** 2, nm / 1000] for nm in range(380, 785, 5)}
    file = tmp_path / "mine.json"
    file.write_text(
        json.dumps({"spectral_data": {"index": {"main": ["B", "G", "R"]}, "data": {"main": table}}})
    )
    assert np.allclose(camera_sensitivities(file=file)[:, 0], WAVELENGTHS_NM / 1000)


def test_curves_that_do_not_cover_the_visible_range(tmp_path):
    with pytest.raises(SpectralDataError, match=r"short\.csv covers 430-700 nm, but 400-700 nm is needed"):
        camera_sensitivities(file=write_csv(tmp_path / "short.csv", 430, 700))


AMPAS_EMPTY = '{"spectral_data": {"index": {"main": ["R","G","B"]}, "data": {"main": {}}}}'


def table(values):
    """A camera's CSV from a function of the wavelength."""
    rows = [f"{nm}," + ",".join(str(value) for value in values(nm)) for nm in range(380, 790, 10)]
    return "nm,r,g,b\n" + "\n".join(rows) + "\n"


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.csv", "nothing here", "has no table of a spectrum"),
        ("a.csv", "nm,a\n400,1\n700,2\n", r"is no table of sensitivities: it has 1 column"),
        (
            "a.csv",
            "nm,r,g,b\n400,1,2,3\n500,1,x,3\n700,1,2,3\n",
            'a line among its numbers that is none: "500,1,x,3"',
        ),
        ("a.json", "{}", "not a file in AMPAS JSON"),
        ("a.json", "[1, 2", "not a file in AMPAS JSON"),
        ("a.csv", table(lambda nm: (1, 1, np.nan if nm == 500 else 3)), 'no number at 500 nm in column "b"'),
        ("a.json", AMPAS_EMPTY, "not a file in AMPAS JSON"),
        ("a.csv", table(lambda nm: (nm, nm, 900 - nm)), "channels that are alike.*singular"),
        ("a.csv", table(lambda nm: (0, nm, 900 - nm)), "channel without any sensitivity"),
        ("a.csv", table(lambda nm: (-nm, nm, 900 - nm)), "negative sensitivity"),
        ("a.csv", "nm,r,g,b\n400,1,2,3\n400,1,2,3\n700,1,1,3\n", "lists a wavelength twice"),
    ],
)
def test_files_that_are_none(tmp_path, name, text, message):
    file = tmp_path / name
    file.write_text(text)
    with pytest.raises(SpectralDataError, match=message):
        camera_sensitivities(file=file)


def test_a_missing_file(tmp_path):
    with pytest.raises(SpectralDataError, match="There is no file at"):
        camera_sensitivities(file=tmp_path / "none.csv")


def test_files_of_the_academys_collection(shared_dir):
    for file in sorted((shared_dir / "spectra" / "cameras").glob("*.csv")):
        assert camera_sensitivities(file=file).shape == (61, 3), file.name


def test_curves_normalised_channel_by_channel_have_lost_their_gains():
    curves = camera_sensitivities("Canon EOS 5D Mark II")
    assert gains_remark("it", curves) is None
    assert gains_lost(curves / curves.max(0))
    assert "Calibrate" in gains_remark("it", curves / curves.max(0))
    assert not gains_lost(camera_sensitivities("Rec.709"))


def test_the_academys_cameras_that_lost_their_gains(shared_dir):
    folder = shared_dir / "spectra" / "cameras"
    lost = {name for name, file in cameras_in(folder).items() if gains_lost(camera_sensitivities(file=file))}
    assert lost == {"ARRI D21", "Nikon D5100"}


def test_a_folder_of_cameras(tmp_path):
    write_csv(tmp_path / "Acme_One_380_780_5.csv", 380, 780)
    (tmp_path / "lamp.csv").write_text("nm,value\n400,1\n700,1\n")
    rows = {str(nm): [nm / 1000, (nm / 900) ** 2, (800 - nm) / 800] for nm in range(380, 785, 5)}
    spectral = {"index": {"main": ["R", "G", "B"]}, "data": {"main": rows}}
    header = {"manufacturer": "Acme", "model": "Two"}
    (tmp_path / "second.json").write_text(json.dumps({"header": header, "spectral_data": spectral}))
    assert list(cameras_in(tmp_path)) == ["Acme One", "Acme Two"]
    for model in ("Acme Two", "acme_two", "second"):
        assert camera_sensitivities(model, tmp_path).shape == (61, 3)
    with pytest.raises(SpectralDataError, match=r'no camera called "Acme Too".*Did you mean "Acme Two"'):
        camera_sensitivities("Acme Too", tmp_path)
    with pytest.raises(SpectralDataError, match="holds 2 cameras"):
        camera_sensitivities(None, tmp_path)


def test_names_known_without_the_library_are_those_of_the_library():
    assert (*LIBRARY_CAMERAS, REC709) == camera_names()
