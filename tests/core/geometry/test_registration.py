"""Views of known rotations, given wrong, must find back; those that show something else must stay."""

import numpy as np
import pytest

from spectral_probe.geometry.bundle import angle_between
from spectral_probe.geometry.frames import camera_to_world, view_angles
from spectral_probe.geometry.registration import register_views, register_with_partners

THREE = [(0, 0, 0), (120, 5, -2), (240, -4, 1)]


def errors_deg(registration, angles):
    """Angle between each view's rotation as registered and the true one."""
    return np.degrees(
        [
            angle_between(view.rotation, camera_to_world(*true))
            for view, true in zip(registration.views, angles, strict=True)
        ]
    )


@pytest.mark.parametrize(
    "wrong", [[(3, 1, -1), (-3, -1.5, 2)], [(-12, 4, 3), (14, -3, -4)]], ids=["3 degrees", "14 degrees"]
)
def test_three_views_find_back(surroundings, wrong):
    world = surroundings()
    views = [world.view(true, error) for true, error in zip(THREE, [(0, 0, 0), *wrong], strict=True)]
    found = register_views(views)
    assert errors_deg(found, THREE).max() < 0.1
    assert errors_deg(found, THREE)[0] == 0  # the first view is the anchor
    assert not found.warnings
    for view in found.views:
        assert view.residual_deg < 0.15
        assert view.correlation > 0.9
        assert np.allclose(view.gain, 1, atol=0.005)
    assert all(view.correlation > view.nominal_correlation + 0.02 for view in found.views)


def test_opposite_views_find_back(surroundings):
    """They share what lies around the ring between them, far from the middle of either."""
    angles = [(30, 0, 0), (210, 0, 0)]
    world = surroundings()
    found = register_views([world.view(angles[0]), world.view(angles[1], (4, -2, 1.5))])
    assert errors_deg(found, angles).max() < 0.15


def test_a_near_room_does_not_turn_the_views(surroundings):
    """Walls two metres away: things appear up to 1.4 degrees apart, from one view to the next."""
    world = surroundings(distance_m=2.0)
    views = [
        world.view(true, error)
        for true, error in zip(THREE, [(0, 0, 0), (3, 1, -1), (-3, 0, 2)], strict=True)
    ]
    assert errors_deg(register_views(views), THREE).max() < 0.1


def test_exact_angles_stay_exactly(surroundings):
    world = surroundings(distance_m=4.0)
    found = register_views([world.view(true) for true in THREE])
    assert errors_deg(found, THREE).max() < 1e-6


def test_views_that_may_not_turn_do_not(surroundings):
    """With refine = false on one view, that one is the anchor and the first view moves to it."""
    world = surroundings()
    views = [world.view(THREE[0], (3, 0, 0)), world.view(THREE[1], refine=False), world.view(THREE[2])]
    found = register_views(views)
    assert errors_deg(found, THREE).max() < 0.1


def test_gains_are_matched_to_the_anchor(surroundings):
    world = surroundings()
    factors = [1.0, 1.5, 0.7]
    views = [
        world.view(true, change=lambda directions, radiance, factor=factor: factor * radiance)  # noqa: ARG005 (as called)
        for true, factor in zip(THREE, factors, strict=True)
    ]
    for view, factor in zip(register_views(views).views, factors, strict=True):
        assert np.allclose(view.gain * factor, 1.0, atol=0.01)


def test_a_view_of_something_else_stays_and_says_so(surroundings):
    world, other = surroundings(), surroundings(seed=11)
    views = [world.view(THREE[0]), world.view(THREE[1], (2, 0, 0)), other.view(THREE[2], (1, 0, 0))]
    found = register_views(views)
    assert [view.registered for view in found.views] == [True, True, False]
    assert view_angles(found.views[2].rotation) == pytest.approx((241, -4, 1))
    assert errors_deg(found, THREE)[1] < 0.15
    (warning,) = found.warnings
    assert "View 3 shows too little in common" in warning


def test_many_views_at_unequal_angles(surroundings):
    angles = [(0, 0, 0), (31, 20, 2), (75, -10, 0), (140, 35, -3), (185, 5, 1), (260, 15, 0), (318, -5, 4)]
    rng = np.random.default_rng(5)
    world = surroundings(distance_m=6.0)
    views = [world.view(true, rng.uniform(-2.5, 2.5, 3) * (number > 0)) for number, true in enumerate(angles)]
    assert errors_deg(register_views(views), angles).max() < 0.12


def test_one_view_needs_no_registration(surroundings):
    (view,) = register_views([surroundings().view((40, 10, 0))]).views
    assert view_angles(view.rotation) == pytest.approx((40, 10, 0))
    assert np.array_equal(view.gain, np.ones(3))


def test_black_views_are_told_not_to_fit(surroundings):
    def dark(_, radiance):
        return 0 * radiance

    found = register_views(
        [surroundings().view(THREE[0], change=dark), surroundings().view(THREE[1], change=dark)]
    )
    assert errors_deg(found, THREE[:2]).max() < 1e-6
    assert len(found.warnings) == 1
    assert all(np.isfinite(view.gain).all() for view in found.views)


def test_views_through_filters_follow_their_partners(surroundings):
    """Green and dark, they would be no match; they take the rotation and the gain of their partners, whatever the order."""
    world = surroundings()

    def green(_, radiance):
        return radiance * np.array([0.02, 0.4, 0.01])

    errors = [(0, 0, 0), (3, 1, 0), (-2, 0, 1)]
    views = [world.view(true, error) for true, error in zip(THREE, errors, strict=True)]
    filtered = world.view(THREE[1], errors[1], change=green)
    alone = register_views(views)
    together = register_with_partners([filtered, *views], [2, 1, 2, 3])
    for one, other in zip(together.views, [alone.views[1], *alone.views], strict=True):
        assert np.array_equal(one.rotation, other.rotation)
        assert np.array_equal(one.gain, other.gain)


def test_warnings_name_a_view_by_its_place_among_all(surroundings):
    same = surroundings().view(THREE[0])
    found = register_with_partners([same, same, surroundings(seed=11).view(THREE[1], (3, 0, 0))], [0, 0, 2])
    assert [view.registered for view in found.views] == [True, True, False]
    assert found.warnings[0].startswith("View 3 ")
