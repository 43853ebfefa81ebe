from __future__ import annotations

import numpy as np

from arjuna_slam.graph.drift import Drift


def driven(count: int) -> Drift:
    """A keyframe each metre."""
    drift = Drift()
    drift.travel.extend(float(k) for k in range(count))
    return drift


def test_without_loops_drift_grows_with_the_way_between() -> None:
    assert driven(101).between(100, 20) == 80.0


def test_a_loop_is_a_short_cut_to_what_lies_around_it() -> None:
    drift = driven(101)
    drift.close(95, 10)
    assert drift.between(100, 10) == 5.0
    assert drift.between(100, 13) == 8.0
    assert drift.between(100, 50) == 45.0
    assert drift.between(100, 60) == 40.0


def test_a_loop_with_the_place_just_left_says_nothing_of_older_ones() -> None:
    drift = driven(101)
    drift.close(100, 98)
    assert drift.between(100, 10) == 88.0


def test_a_session_goes_on_where_it_ended() -> None:
    drift = Drift()
    drift.resume(np.arange(51.0))
    drift.travel.append(52.0)
    assert drift.between(51, 3) == 2.0
