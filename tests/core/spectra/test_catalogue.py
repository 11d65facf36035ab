import numpy as np
import pytest

from spectral_probe.errors import SpectralDataError
from spectral_probe.spectra.catalogue import as_tabulated, catalogue, curves_of, find, search
from spectral_probe.spectra.grid import WAVELENGTHS_NM
from spectral_probe.spectra.library import FAMILIES, daylight, lamp_spectrum, planck, training_lights
from spectral_probe.spectra.own_files import own_entries, own_entry
from spectral_probe.spectra.passports import KINDS


def test_every_entry_has_a_passport_and_curves_that_can_be():
    entries = catalogue()
    assert {entry.kind for entry in entries} == set(KINDS)
    assert len({(entry.kind, entry.name) for entry in entries}) == len(entries)
    for entry in entries:
        for text in (entry.name, entry.family, entry.quantity, entry.unit, entry.licence, entry.source):
            assert text.strip(), entry
        assert entry.first_nm < entry.last_nm
        for name, curve in curves_of(entry).items():
            assert curve.shape == (61,), entry.name
            assert np.isfinite(curve).all(), entry.name
            assert curve.min() >= 0 or entry.name == "Rec.709", entry.name
            assert curve.max() <= 1 or not name.startswith(("reflectance", "transmittance")), entry.name


def test_every_lamp_of_the_families_is_listed_under_its_family():
    listed = {entry.name: entry.family for entry in catalogue("lamp")}
    for family, names in FAMILIES.items():
        assert {listed[name] for name in names} == {family}
        lights = training_lights([family])
        for name in names:
            assert np.abs(lights - lamp_spectrum(name)).max(1).min() == 0


def test_lamps_by_temperature():
    assert lamp_spectrum("planck 3200k") == pytest.approx(planck(3200.0))
    assert lamp_spectrum("Daylight 6504 K") == pytest.approx(lamp_spectrum("D65"), rel=5e-3)
    nm, power = as_tabulated(find("Daylight 5000 K"))
    assert (nm[0], nm[-1]) == (360.0, 830.0)
    assert np.interp(WAVELENGTHS_NM, nm, power) == pytest.approx(daylight(5000.0))
    with pytest.raises(SpectralDataError, match="Give 4000 to 25000 K"):
        find("Daylight 2000 K")


def test_names_are_found_whatever_their_capitals_and_by_kind_where_two_share_one():
    assert find("fl11").name == "FL11"
    assert find("Gold").name == "Au"
    assert find("dark skin").name == "ColorChecker N Ohta: dark skin"
    assert find("stainless steel").kind == "metal"
    assert find("stainless steel", "ball").kind == "ball"
    assert find("main/Cu/Babar").kind == "metal"
    assert list(curves_of(find("main/SiO2/Malitson"))) == ["n", "reflectance"]


@pytest.mark.parametrize(
    ("name", "kind", "message"),
    [
        ("FL 11", None, 'Did you mean "FL11"'),
        ("Nikon 5100", "camera", 'no camera called .*Did you mean "Nikon 5100 '),
        ("3-LED-1 (457/540/606)", None, r'Did you mean "3-LED-1 \(457/540/605\)"'),
        ("golt", "ball", "no ball called"),
        ("dark skinn", None, 'Did you mean "ColorChecker N Ohta: dark skin"'),
        ("xyzzy", None, "library search xyzzy"),
        ("main/Au/Nobody", None, "has no page"),
    ],
)
def test_names_that_are_none(name, kind, message):
    with pytest.raises(SpectralDataError, match=message):
        find(name, kind)


def test_a_kind_that_is_none():
    with pytest.raises(SpectralDataError, match='Did you mean "lamp"'):
        catalogue("lamps")


def test_search_looks_everywhere():
    assert {"metal", "ball"} == {entry.kind for entry in search(["steel"])}
    assert [entry.name for entry in search(["dark", "skin", "ohta"])] == ["ColorChecker N Ohta: dark skin"]
    assert all(entry.remark for entry in search(["werner", "2009"]))


def test_pages_never_to_be_used_are_no_defaults():
    assert not any("Werner" in entry.family for entry in catalogue("metal"))


def test_a_folder_of_the_users_own(tmp_path):
    def write(name, heading, value):
        rows = [f"{nm},{value(nm)}" for nm in range(380, 790, 10)]
        (tmp_path / name).write_text("\n".join([heading, *rows]))

    write("desk lamp.csv", "# licence: CC0\n# source: me\nnm,power", lambda nm: nm)
    write("wall.csv", "nm,reflectance", "0.4".format)
    write("red filter.csv", "nm,T", lambda nm: nm / 1000)
    write("cam.csv", "nm,r,g,b", lambda nm: f"{nm},{(nm / 500) ** 3},{900 - nm}")
    write("broken reflectance.csv", "nm,value", "40".format)
    write("alike.csv", "nm,r,g,b", lambda nm: f"{nm},{nm},{900 - nm}")
    write("found.csv", "wavelength_nm,radiance,standard_error,measured", lambda nm: f"{nm},1,{nm}")
    (tmp_path / "notes.txt").write_text("nothing")
    own = [entry for entry in catalogue(None, tmp_path) if entry.family.startswith("own file")]
    assert {(entry.name, entry.kind) for entry in own} == {
        ("desk lamp", "lamp"),
        ("wall", "reflectance"),
        ("red filter", "glass"),
        ("cam", "camera"),
        ("found", "lamp"),
    }
    lamp = find("desk lamp", None, tmp_path)
    assert (lamp.licence, lamp.source, lamp.last_nm) == ("CC0", "me", 780.0)
    assert curves_of(lamp, tmp_path)["relative_power"] == pytest.approx(WAVELENGTHS_NM)
    assert as_tabulated(lamp, tmp_path)[0].max() == 780
    assert curves_of(find("cam", None, tmp_path), tmp_path)["r"] == pytest.approx(WAVELENGTHS_NM)
    assert search(["red", "filter"], tmp_path)[0].name == "red filter"
    complaints = own_entries(tmp_path)[1]
    assert [sentence.split()[0] for sentence in complaints] == ["alike.csv", "broken", "notes.txt"]
    assert own_entry(tmp_path / "red filter.csv", "lamp").passport.kind == "lamp"
    with pytest.raises(SpectralDataError, match=r"broken reflectance\.csv seems to be in percent"):
        own_entry(tmp_path / "broken reflectance.csv")
    with pytest.raises(SpectralDataError, match="cannot be shown as a metal"):
        own_entry(tmp_path / "wall.csv", "metal")
    with pytest.raises(SpectralDataError, match="There is no folder"):
        catalogue(None, tmp_path / "none")
