"""Light groups: every object is in one, and no channel holds two spectra."""

import pytest

from spectral_probe.render.light_groups import RGB_GROUP, Emitter, assign


def check(assignment, objects):
    for group, members in zip(assignment.groups, objects, strict=True):
        for emitter in members:
            name = assignment.spectra[emitter]
            if group == RGB_GROUP:
                assert not name
            else:
                assert assignment.members[group][assignment.channels[name]] == name


@pytest.mark.parametrize("lamps", [1, 3, 4, 7])
def test_lamps_by_themselves_fill_groups_of_three(lamps):
    objects = [frozenset({n}) for n in range(lamps)]
    result = assign([Emitter(f"lamp {n}") for n in range(lamps)], objects)
    check(result, objects)
    assert len(result.members) == -(-lamps // 3)


def test_lamps_of_one_spectrum_share_a_channel():
    objects = [frozenset({0}), frozenset({1})]
    result = assign([Emitter("FL11"), Emitter("FL11")], objects)
    assert result.members == {"lamps 1": ("FL11", "", "")}


def test_a_chain_of_shared_objects_is_solved():
    objects = [frozenset({n, (n + 1) % 5}) for n in range(5)]  # an odd ring: needs all three channels
    result = assign([Emitter(f"lamp {n}") for n in range(5)], objects)
    check(result, objects)
    assert all(result.spectra)


def test_four_spectra_on_one_object_become_rgb_and_others_stay():
    objects = [frozenset({0, 1, 2, 3}), frozenset({4})]
    result = assign([Emitter(f"lamp {n}") for n in range(5)], objects)
    check(result, objects)
    assert result.spectra == ("", "", "", "", "lamp 4")


def test_a_texture_beside_a_lamp_makes_it_rgb_wherever_it_shines():
    objects = [frozenset({0, 1}), frozenset({0}), frozenset({0, 2})]
    emitters = [Emitter("FL11"), Emitter(), Emitter(constant="red")]
    result = assign(emitters, objects)
    check(result, objects)
    assert set(result.groups) == {RGB_GROUP}
