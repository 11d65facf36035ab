"""A material chosen from the list, and one dragged out of the asset browser, in a real window."""


def test_swatches_are_listed_and_an_asset_is_dragged_onto_an_object(scenario):
    outcome = scenario("material_library")
    assert outcome.results["found"][0] == "Au"
    assert len(outcome.results["found"]) > 5, "pages of refractiveindex.info among it"
    assert outcome.results["chosen"] == "Cu"
    name, kind, editable = outcome.results["dropped"]
    assert name == "BK7 Glass", "the first of the library"
    assert kind == "DISPERSIVE"
    assert editable
    assert outcome.results["left"] == []
