import json

import numpy as np
import pytest

from spectral_probe.errors import SpectralDataError
from spectral_probe.files.spectrum_csv import read_spectrum_csv
from spectral_probe.files.spectrum_file import read_curves, read_samples
from spectral_probe.spectra.colour_science import colour
from spectral_probe.spectra.curves import LIGHT, NUMBER, REFLECTANCE, SENSITIVITY, TRANSMITTANCE
from spectral_probe.spectra.grid import STEP_NM, WAVELENGTHS_NM


def ramp(nm):
    return (np.asarray(nm, float) - 300) / 500


TRUTH = ramp(WAVELENGTHS_NM)


def write(path, text, **how):
    path.write_text(text, **how)
    return path


def rows(separator=",", decimal=".", step=10, first=380, last=780):
    return "\n".join(
        f"{nm}{separator}{ramp(nm):.6f}".replace(".", decimal) for nm in range(first, last + 1, step)
    )


@pytest.mark.parametrize(
    "text",
    [
        rows(),
        "wavelength_nm, reflectance\n" + rows(", "),
        "\n# a comment\nWellenlänge;Reflexion\n" + rows(";", ","),
        "nm\tvalue\n" + rows("\t"),
        "nm\tvaleur\n" + rows("\t", ","),
        "lamp 12\n\n" + rows("   "),
        rows(" ", ","),
        rows(";").replace("\n", ";\n") + ";\n",
        '"nm","R"\n' + "\n".join(f'"{nm}","{ramp(nm):.6f}"' for nm in range(380, 790, 10)),
        "\r\n".join(reversed(rows().splitlines())),
        rows() + "\nmeasured on a Tuesday\n",
        "\n".join(f"{line},0.01" for line in rows().splitlines()),  # a standard error beside it
    ],
    ids=[
        "comma", "comma and blank", "semicolon, decimal comma", "tab", "tab, decimal comma", "blanks",
        "blank, decimal comma", "semicolon", "quoted", "descending, CRLF", "footer", "second column",
    ],
)  # fmt: skip
def test_text_of_every_country(tmp_path, text):
    assert read_spectrum_csv(write(tmp_path / "a.csv", text, encoding="utf-8"))[0] == pytest.approx(TRUTH)


def test_a_byte_order_mark_and_an_old_encoding(tmp_path):
    marked = write(tmp_path / "a.csv", "Wellenlänge;Licht\n" + rows(";"), encoding="utf-8-sig")
    assert read_samples(marked).columns == ("Licht",)
    windows = write(tmp_path / "c.csv", "Länge;Größe\n" + rows(";"), encoding="utf-16")
    assert read_samples(windows).columns == ("Größe",)
    latin = write(tmp_path / "b.csv", "Länge;Größe\n" + rows(";"), encoding="latin-1")
    assert read_samples(latin).columns == ("Größe",)


def test_a_line_keeps_its_power_in_a_fine_table(tmp_path):
    """A mercury line one nanometre wide, over a faint continuum, wherever it falls in a band."""
    for line_nm in (404, 435, 546, 547, 577):
        nm = np.arange(380, 781)
        values = 0.01 + 5.0 * (nm == line_nm)
        table = "\n".join(f"{a},{b}" for a, b in zip(nm, values, strict=True))
        spectrum = read_spectrum_csv(write(tmp_path / "line.csv", table))[0]
        assert spectrum.sum() * STEP_NM == pytest.approx(0.01 * 305 + 5.0, rel=1e-9)
        centre = ((spectrum - 0.01) * WAVELENGTHS_NM).sum() / (spectrum - 0.01).sum()
        assert abs(centre - line_nm) <= STEP_NM / 2


@pytest.mark.parametrize("step", [1, 2, 3, 4, 5, 10, 20, 50])
def test_a_smooth_curve_stays_itself_whatever_the_step(tmp_path, step):
    file = write(tmp_path / "a.csv", rows(step=step))
    assert read_spectrum_csv(file)[0] == pytest.approx(TRUTH, abs=1e-6)


def test_a_table_from_400_to_700_is_enough_and_bands_half_covered_are(tmp_path):
    assert read_spectrum_csv(write(tmp_path / "a.csv", rows(step=5, first=400, last=700))) is not None
    offset = "\n".join(f"{nm},{ramp(nm)}" for nm in np.arange(401.5, 700, 3.3))
    assert read_spectrum_csv(write(tmp_path / "b.csv", offset))[0] == pytest.approx(TRUTH, abs=5e-3)


def test_ies_tm27(tmp_path):
    data = "".join(f'<SpectralData wavelength="{nm}">{ramp(nm)}</SpectralData>' for nm in range(380, 785, 5))
    text = (
        '<?xml version="1.0" encoding="utf-8"?><IESTM2714 xmlns="iestm2714" version="1.0"><Header>'
        "<Manufacturer>Acme</Manufacturer><Description>lamp</Description></Header><SpectralDistribution>"
        f"<SpectralQuantity>relative</SpectralQuantity>{data}</SpectralDistribution></IESTM2714>"
    )
    samples = read_samples(write(tmp_path / "lamp.spdx", text))
    assert (samples.columns, samples.source) == (("relative",), "Acme, lamp")
    assert read_spectrum_csv(tmp_path / "lamp.spdx")[0] == pytest.approx(TRUTH)


def test_an_entity_bomb_is_refused_before_it_is_parsed(tmp_path):
    bomb = '<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a "1"><!ENTITY b "&a;&a;">]><IESTM2714>&b;</IESTM2714>'
    with pytest.raises(SpectralDataError, match="declares a document type"):
        read_samples(write(tmp_path / "bomb.spdx", bomb))


def test_ampas_json_of_a_lamp(tmp_path):
    table = {str(nm): [ramp(nm)] for nm in range(780, 375, -5)}
    document = {
        "header": {"license": "Apache-2.0", "laboratory": "Acme"},
        "spectral_data": {"index": {"main": ["Light"]}, "data": {"main": table}},
    }
    file = write(tmp_path / "lamp.json", json.dumps(document))
    samples = read_samples(file)
    assert (samples.columns, samples.licence, samples.source) == (("Light",), "Apache-2.0", "Acme")
    assert read_curves(file, LIGHT)[0] == pytest.approx(TRUTH)


def test_cgats_of_x_rite(tmp_path):
    nm = range(380, 740, 10)
    text = (
        "LGOROWLENGTH 10\nBEGIN_DATA_FORMAT\nSampleID SAMPLE_NAME " + " ".join(f"nm{at}" for at in nm) + "\n"
        'END_DATA_FORMAT\nBEGIN_DATA\n1 "dark skin" '
        + " ".join(f"{ramp(at):.6f}" for at in nm)
        + "\nEND_DATA\n"
    )
    file = write(tmp_path / "patches.txt", text)
    assert read_samples(file).columns == ("dark skin",)
    assert read_curves(file, REFLECTANCE)[0] == pytest.approx(TRUTH, abs=1e-6)


def test_spectrometers_own_exports(tmp_path):
    """UPRtek: "380nm<tab>value"; Sekonic: a 5 nm table, then one of 1 nm, which is the one to take."""
    uprtek = "Model Name\tCV600\nLUX\t695.2\n" + "\n".join(f"{nm}nm\t{ramp(nm)}" for nm in range(380, 781))
    assert read_spectrum_csv(write(tmp_path / "a.xls", uprtek))[0] == pytest.approx(TRUTH)
    sekonic = "Title,lamp\nTcp [K],3262\n"
    for step, factor in ((5, 9.0), (1, 1.0)):
        sekonic += "".join(f"Spectral Data {nm}[nm],{factor * ramp(nm)}\n" for nm in range(380, 781, step))
        sekonic += "---\n"
    assert read_spectrum_csv(write(tmp_path / "b.csv", sekonic))[0] == pytest.approx(TRUTH)


def test_files_that_colour_science_is_tested_with():
    folder = __import__("pathlib").Path(colour.__file__).parent / "io" / "tests" / "resources"
    if not folder.is_dir():
        pytest.skip("this colour-science was installed without its tests")
    lamp = read_curves(folder / "Fluorescent.spdx", LIGHT)[0]
    assert WAVELENGTHS_NM[lamp.argmax()] == pytest.approx(545)
    theirs = colour.SpectralDistribution_UPRTek(str(folder / "ESPD2021_0104_231446.xls")).read()
    ours = read_samples(folder / "ESPD2021_0104_231446.xls")
    assert ours.values[0] == pytest.approx(theirs.values)
    patches = colour.read_sds_from_xrite_file(folder / "X-Rite_Digital_Colour_Checker.txt")
    read = read_samples(folder / "X-Rite_Digital_Colour_Checker.txt")
    assert dict(zip(read.columns, read.values.tolist(), strict=True)) == {
        name: patch.values.tolist() for name, patch in patches.items()
    }


def constant(value, step=10, first=380, last=780):
    return "\n".join(f"{nm},{value}" for nm in range(first, last + 1, step))


@pytest.mark.parametrize(
    ("text", "quantity", "message"),
    [
        (rows() + "\n780,1\n", LIGHT, r"lists a wavelength twice \(780 nm\)"),
        (rows(last=600) + "\n" + rows(first=595), LIGHT, "do not ascend: after 600 comes 595.*two scans overlap"),
        (rows(last=500) + "\n" + rows(first=560), LIGHT, "no row between 500 and 560 nm"),
        ("400,1\n450,1\n600,1\n700,1", LIGHT, "no row between 450 and 600 nm"),
        (rows(first=430), LIGHT, "covers 430-780 nm, but 400-700 nm is needed"),
        (rows(last=690), LIGHT, "covers 380-690 nm"),
        ("\n".join(f"{nm / 1000},1" for nm in range(380, 790, 10)), LIGHT, "looks like micrometres.*by 1000"),
        ("\n".join(f"{nm}e-9,1" for nm in range(380, 790, 10)), LIGHT, "looks like metres.*by 1e9"),
        ("\n".join(f"{nm * 10},1" for nm in range(380, 790, 10)), LIGHT, "looks like angstroms.*by 10"),
        (constant(0.5).replace("500,0.5", "500,nan"), LIGHT, "no number at 500 nm"),
        (constant(0.5).replace("500,0.5", "500,inf"), LIGHT, "no number at 500 nm"),
        (constant(0.5).replace("500,0.5", "500,"), LIGHT, "no number at 500 nm"),
        (constant(0.5).replace("500,0.5", "500,oops"), LIGHT, 'that is none: "500,oops"'),
        (constant(0.5).replace("500,0.5", "500,0.5,3"), LIGHT, r"has 2 value\(s\) at 500 nm, but 1 at 380"),
        (constant(0.5).replace("500,0.5", "500,-0.1"), LIGHT, "negative spectral power at 500 nm"),
        (constant(0.5).replace("500,0.5", "500,-0.1"), REFLECTANCE, "negative reflectance at 500 nm"),
        (constant(0), LIGHT, "without any spectral power"),
        (constant(91.5), TRANSMITTANCE, "seems to be in percent.*Divide it by 100"),
        (constant(1.3), TRANSMITTANCE, "transmittance above 1"),
        (constant(1.3), REFLECTANCE, "reflectance above 1"),
        ("nm,T (%)\n" + constant(0.9), TRANSMITTANCE, r'calls its values "T \(%\)"'),
        ("", LIGHT, "has no table of a spectrum"),
        ("nm,value\n", LIGHT, "has no table of a spectrum"),
        ("500,1\n", LIGHT, "has no table of a spectrum"),
        (constant(1), SENSITIVITY, r"has 1 column\(s\) of values, but 3 are needed"),
        ("<a>", LIGHT, "not valid IES TM-27"),
        ("<a/>", LIGHT, "XML without SpectralData"),
    ],
)  # fmt: skip
def test_bad_input_is_told_in_one_sentence(tmp_path, text, quantity, message):
    file = write(tmp_path / "mine.csv", text)
    with pytest.raises(SpectralDataError, match=message) as told:
        read_curves(file, quantity, columns=3 if quantity == SENSITIVITY else 1)
    assert "mine.csv" in str(told.value)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    ("value", "quantity", "kept"),
    [(1.01, REFLECTANCE, 1.0), (-0.01, TRANSMITTANCE, 0.0), (0.0, TRANSMITTANCE, 0.0), (1.5, LIGHT, 1.5), (1.5, NUMBER, 1.5)],
)  # fmt: skip
def test_what_an_instruments_noise_does_is_no_error(tmp_path, value, quantity, kept):
    assert (read_curves(write(tmp_path / "a.csv", constant(value)), quantity) == kept).all()


def test_files_that_are_not_there(tmp_path):
    with pytest.raises(SpectralDataError, match="There is no file at"):
        read_samples(tmp_path / "none.csv")
    with pytest.raises(SpectralDataError, match="is a folder"):
        read_samples(tmp_path)
    (tmp_path / "picture.csv").write_bytes(bytes(range(256)) * 20)
    with pytest.raises(SpectralDataError, match="no table of a spectrum"):
        read_samples(tmp_path / "picture.csv")
