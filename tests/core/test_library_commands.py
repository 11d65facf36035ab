import json

import matplotlib.image
import numpy as np
import pytest

from spectral_probe.cli import main
from spectral_probe.files.spectrum_csv import read_spectrum_csv
from spectral_probe.spectra.library import lamp_spectrum, planck


@pytest.fixture
def run(capsys):
    def run(*words):
        code = main(["library", *map(str, words)])
        out, err = capsys.readouterr()
        return code, out, err

    return run


def shown(run, *words):
    code, out, _ = run("show", *words, "--json")
    assert code == 0
    return json.loads(out)


def test_list_by_kind(run):
    code, out, _ = run("list", "ball")
    assert code == 0
    assert out.splitlines()[0] == "ball:"
    assert out.splitlines()[1].split()[0] == "SUS304"
    entries = json.loads(run("list", "camera", "--json")[1])["entries"]
    assert {"name", "kind", "licence", "source", "first_nm"} <= set(entries[0])


@pytest.mark.parametrize(
    ("lamp", "xy", "kelvin"),
    [  # published in CIE 015:2018; Planck 3200 K by its own temperature
        ("A", (0.4476, 0.4075), 2856),
        ("D65", (0.3127, 0.3290), 6504),
        ("FL2", (0.3721, 0.3751), 4230),
        ("FL11", (0.3805, 0.3769), 4000),
        ("LED-B1", (0.4560, 0.4078), 2733),
        ("HP1", (0.5330, 0.4150), 1959),
        ("Planck 3200 K", (0.4234, 0.3990), 3200),
    ],
)
def test_colour_of_lamps(run, lamp, xy, kelvin):
    numbers = shown(run, *lamp.split())
    assert numbers["xy"] == pytest.approx(xy, abs=6e-4)
    assert numbers["cct_kelvin"] == pytest.approx(kelvin, abs=0.003 * kelvin)


def test_numbers_of_the_other_kinds(run):
    gold = shown(run, "gold")
    assert gold["reflectance"] == {"450_nm": 0.4083, "550_nm": 0.7923, "650_nm": 0.9587}
    assert {"n", "k"} <= set(gold)
    camera = shown(run, "Nikon 5100 (NPL)")
    assert camera["peaks_nm"]["b"] == 460
    assert "gains of its channels are lost" in camera["remark"]
    patch = shown(run, "ColorChecker N Ohta: dark skin")
    assert patch["xy_d65"] == pytest.approx([0.41, 0.363], abs=2e-3)
    assert patch["y_d65"] == pytest.approx(0.097, abs=2e-3)
    assert shown(run, "ball", "stainless", "steel")["reflectance_0deg"]["550_nm"] == pytest.approx(
        0.641, abs=2e-3
    )
    assert "never used by default" in shown(run, "main/Fe/Werner")["remark"]


def test_search_tells_names_that_show_takes(run):
    found = json.loads(run("search", "steel", "--json")[1])["entries"]
    for entry in found:
        assert shown(run, entry["kind"], entry["name"])["name"] == entry["name"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("show", "FL", "13"), 'Did you mean "FL'),
        (("show",), "Say what to show"),
        (("search",), "Say what to search for"),
        (("search", "no", "such", "thing"), "Nothing in the library"),
        (("list", "lamps"), 'Did you mean "lamp"'),
        (("list", "--folder", "/no/such/folder"), "There is no folder"),
        (("show", "FL11", "-o", "fl11.jpg"), "Choose one of these endings"),
    ],
)
def test_mistakes_are_one_line_and_2(run, words, message):
    code, out, err = run(*words)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1


def test_what_is_written_is_read_back_and_keeps_its_passport(run, tmp_path):
    shown(run, "FL11", "-o", tmp_path / "new" / "fl11.csv")
    text = (tmp_path / "new" / "fl11.csv").read_text()
    assert "# licence: BSD-3-Clause" in text
    assert read_spectrum_csv(tmp_path / "new" / "fl11.csv")[0] == pytest.approx(
        lamp_spectrum("FL11"), rel=1e-6
    )
    again = shown(run, "fl11", "--folder", tmp_path / "new")
    assert again["kind"] == "lamp"
    assert again["licence"].startswith("BSD-3-Clause")


def test_a_file_of_ones_own_is_shown_or_refused(run, tmp_path):
    (tmp_path / "lamp.csv").write_text(
        "\n".join(f"{nm},{planck(3200, np.array(nm))}" for nm in range(360, 835, 5))
    )
    assert shown(run, tmp_path / "lamp.csv")["cct_kelvin"] == pytest.approx(3200, abs=1)
    (tmp_path / "glass.csv").write_text("\n".join(f"{nm},91" for nm in range(380, 785, 5)))
    code, _, err = run("show", tmp_path / "glass.csv")
    assert (code, err.count("\n")) == (2, 1)
    assert "seems to be in percent" in err
    assert shown(run, "lamp", tmp_path / "glass.csv")["kind"] == "lamp"
    listed = json.loads(run("list", "lamp", "--folder", tmp_path, "--json")[1])
    assert listed["entries"][0]["name"] == "lamp"
    assert "glass.csv" in listed["not_usable"][0]


@pytest.mark.parametrize("name", ["FL11", "gold", "Canon EOS 5D Mark II", "Rec.709", "SUS304"])
def test_a_plot_of_every_kind(run, tmp_path, name):
    shown(run, name, "-o", tmp_path / "plot.png")
    picture = matplotlib.image.imread(tmp_path / "plot.png")
    assert picture.shape[1] == 963
    drawn = (picture[..., :3] < 0.9).any(-1)
    assert 0.02 < drawn.mean() < 0.3  # lines on white, within the frame
    assert not drawn[:, -20:].any()
