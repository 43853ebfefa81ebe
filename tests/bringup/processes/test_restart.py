"""Back-off of restarts."""

from __future__ import annotations

from bringup.processes.restart import RestartLimits, RestartPolicy


def test_delays_double_and_the_fifth_death_in_a_minute_ends_the_attempts() -> None:
    policy, now, delays = RestartPolicy(), 100.0, []
    for _ in range(5):
        delay = policy.on_death(now)
        delays.append(delay)
        now += 0.1 + (delay or 0.0)
    assert delays == [0.2, 0.4, 0.8, 1.6, None]


def test_a_process_that_dies_now_and_then_always_starts_again_at_once() -> None:
    policy = RestartPolicy()
    assert [policy.on_death(61.0 * n) for n in range(20)] == [0.2] * 20


def test_deaths_older_than_the_window_no_longer_count() -> None:
    policy = RestartPolicy(RestartLimits(first_delay=1.0, deaths=3, window=10.0))
    assert policy.on_death(0.0) == 1.0
    assert policy.on_death(6.0) == 2.0
    assert policy.on_death(12.0) == 2.0  # the first is forgotten
    assert policy.on_death(16.0) is None  # the second is just young enough


def test_a_process_that_came_up_each_time_always_starts_again_at_once() -> None:
    policy = RestartPolicy()
    assert [policy.on_death(3.0 * n, was_up=True) for n in range(20)] == [0.2] * 20


def test_policies_do_not_share_their_deaths() -> None:
    first, second = RestartPolicy(), RestartPolicy()
    first.on_death(0.0)
    assert second.on_death(0.0) == 0.2
