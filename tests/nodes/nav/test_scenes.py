"""Random scenes of two lidars, zones and speed limits; `bench scenes` drives more."""

from __future__ import annotations

import pytest

from tests.helpers.nav import scenes


@pytest.mark.parametrize("seed", [16])
def test_nothing_is_touched_that_one_of_two_lidars_alone_sees(seed: int) -> None:
    outcome = scenes.two_lidars(seed)
    assert outcome.reached
    assert outcome.wrong == 0


def test_such_a_scene_needs_both() -> None:
    assert scenes.two_lidars(16, both=False).wrong > 0


@pytest.mark.parametrize("seed", [9])
def test_no_cell_of_a_zone_is_entered(seed: int) -> None:
    outcome = scenes.keepout(seed)
    assert outcome.reached
    assert outcome.wrong == 0


@pytest.mark.parametrize("seed", [1])
def test_limits_of_the_speed_hold_within_five_per_cent(seed: int) -> None:
    outcome = scenes.speed_limits(seed)
    assert outcome.reached
    assert outcome.held > 100
    assert outcome.wrong == 0
    assert outcome.worst > 0.95, "it drives as fast as it may"
