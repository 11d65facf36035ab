"""Plans as files: everything comes back exactly, and what is no plan is named."""

import json
from dataclasses import fields

import numpy as np
import pytest

from spectral_probe.errors import FileFormatError
from spectral_probe.render.plan import describe, load_plan, reference_plan, save_plan
from spectral_probe.render_model import EmissionGroup, PassPlan, SwappableLayer
from spectral_probe.spectra.grid import WAVELENGTHS_NM


def full_plan():
    """A plan with something in every field."""
    generator = np.random.default_rng(5)
    return PassPlan(
        kind="light-basis",
        wavelengths_nm=np.repeat(np.array([[450.0], [550.0], [610.0]]), 3, axis=1),
        reconstruction=generator.normal(size=(3, 3, 61)) / 3,
        grid_nm=WAVELENGTHS_NM.copy(),
        sample_shares=np.array([1 / 16, 0.75, 0.25]),
        references=(1, 1, 2),
        light_sets=(0, 0, 1),
        interpolation=generator.normal(size=(3, 61)),
        emission=(EmissionGroup("lamps 1", generator.random((3, 61)), ("desk", "", "hall")),),
        predicted_de2000=(0.1, 1 / 3),
        predicted_cost=1.0625,
        swappable=(SwappableLayer("window", 1, 2, generator.random(61)),),
        notes=("The light is a mixture of 4 kinds of spectrum.",),
    )


def assert_equal(one, other):
    for field in fields(one):
        mine, its = getattr(one, field.name), getattr(other, field.name)
        if isinstance(mine, np.ndarray):
            np.testing.assert_array_equal(mine, its)
        elif isinstance(mine, tuple) and mine and hasattr(mine[0], "__dataclass_fields__"):
            assert len(mine) == len(its)
            for a, b in zip(mine, its, strict=True):
                assert_equal(a, b)
        else:
            assert mine == its


def test_files_give_back_the_plan_exactly(tmp_path):
    for plan in (full_plan(), reference_plan()):
        save_plan(plan, tmp_path / "plan.json")
        assert_equal(plan, load_plan(tmp_path / "plan.json"))
    assert [path.name for path in tmp_path.iterdir()] == ["plan.json"]


@pytest.mark.parametrize(
    "damage",
    [
        lambda content: content.pop("kind"),
        lambda content: content.update(kind="magic"),
        lambda content: content["wavelengths_nm"].pop(),
        lambda content: content.update(reconstruction="none"),
        lambda content: content.update(format="something else"),
        lambda content: content.update(references=[0, 0, 9]),
        lambda content: content.update(references=[1, 2, 2]),
        lambda content: content.update(interpolation=None),
        lambda content: content["emission"][0].update(swappable=["one"]),
        lambda content: content["swappable"][0].update(channel=3),
        lambda content: content.pop("notes"),
    ],
)
def test_a_damaged_file_is_named(tmp_path, damage):
    path = tmp_path / "plan.json"
    save_plan(full_plan(), path)
    content = json.loads(path.read_text())
    damage(content)
    path.write_text(json.dumps(content))
    with pytest.raises(FileFormatError, match=r"plan\.json is not a plan"):
        load_plan(path)


def test_a_missing_foreign_or_old_file_is_named(tmp_path):
    with pytest.raises(FileFormatError, match="cannot be read"):
        load_plan(tmp_path / "nothing.json")
    (tmp_path / "text.json").write_text("no JSON {")
    with pytest.raises(FileFormatError, match="is not a plan"):
        load_plan(tmp_path / "text.json")
    (tmp_path / "old.json").write_text(json.dumps({"format": "spectral-probe-plan-1"}))
    with pytest.raises(FileFormatError, match=r"earlier version.*Render again"):
        load_plan(tmp_path / "old.json")


def test_a_plan_is_said_in_plain_sentences():
    sentences = describe(full_plan())
    assert sentences[0] == "3 passes of one wavelength each in 2 sets of three light layers."
    assert sentences[1] == "Set 1: 450, 550 nm, the most samples at 550 nm."
    text = " ".join(sentences)
    assert "4 kinds of spectrum" in text
    assert "0.10 in the mean, within 0.33 for 99 of 100 pixels" in text
    assert "1.06 RGB renders" in text
    assert sentences[-1] == "Lights that can be exchanged after rendering: window, desk, hall."
