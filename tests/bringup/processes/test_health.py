"""Reports of processes: health and logs."""

from __future__ import annotations

import os
from datetime import datetime, timedelta, timezone
from pathlib import Path

from bringup.processes.health import Heartbeat, RestartLimits, RestartPolicy, starved
from bringup.processes.output import RUNS_KEPT, RunLog


def test_what_never_gave_a_sign_of_life_is_not_watched() -> None:
    assert Heartbeat().silence(1000.0, 0.0) is None


def test_silence_beyond_the_patience_is_known_with_its_length() -> None:
    heart = Heartbeat()
    heart.hear(10.0, 5.0, 0.0)
    assert heart.silence(14.9, 0.0) is None
    assert heart.silence(16.0, 0.0) == 6.0


def test_a_step_that_was_announced_may_take_its_time() -> None:
    heart = Heartbeat()
    heart.hear(10.0, 90.0, 0.0)
    assert heart.silence(99.0, 0.0) is None
    heart.hear(99.0, 5.0, 0.0)
    assert heart.silence(105.0, 0.0) == 6.0


def test_time_without_a_core_or_without_a_listener_does_not_count() -> None:
    heart = Heartbeat()
    heart.hear(10.0, 5.0, 2.0)
    assert heart.silence(16.0, 4.0) is None
    heart.excuse(30.0)
    assert heart.silence(46.0, 4.0) is None
    assert heart.silence(48.0, 4.0) == 6.0


def test_a_process_s_waiting_for_a_core_is_known_and_none_s_is_0() -> None:
    assert starved(os.getpid()) >= 0.0
    assert starved(2**22 + 1) == 0.0  # more than Linux gives


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


STARTED = datetime(2026, 3, 4, 5, 6, 7, tzinfo=timezone.utc)


def test_lines_go_to_a_file_named_by_date_and_command(tmp_path: Path) -> None:
    log = RunLog("nav", STARTED, tmp_path)
    log.write("[navigation] 100 % ready")
    log.close()
    assert log.path == tmp_path / "20260304-050607-nav" / "log.txt"
    assert log.path.read_text().endswith(" [navigation] 100 % ready\n")


def test_two_runs_of_one_second_have_two_files(tmp_path: Path) -> None:
    logs = [RunLog("nav", STARTED, tmp_path) for _ in range(2)]
    assert len({log.path for log in logs}) == 2
    for log in logs:
        log.close()


def test_only_the_last_runs_are_kept_and_what_is_no_run_stays(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    for second in range(RUNS_KEPT + 3):
        RunLog("sim", STARTED + timedelta(seconds=second), tmp_path).close()
    names = sorted(folder.name for folder in tmp_path.iterdir())
    assert names[-1] == "mine"
    assert len(names) == RUNS_KEPT + 1
    assert names[0] == "20260304-050610-sim"


def test_a_folder_that_cannot_be_made_stops_nothing(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    log = RunLog("sim", STARTED, tmp_path / "file")
    log.write("lost")
    assert log.path is None
