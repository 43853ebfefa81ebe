"""Reports of processes: health and logs."""

from __future__ import annotations

import os
from collections.abc import Sequence
from datetime import datetime, timedelta, timezone
from pathlib import Path

import pytest

from bringup.processes.health import Heartbeat, RestartLimits, RestartPolicy, starved
from bringup.processes.output import RUNS_KEPT, RunLog


def test_silence_beyond_the_patience_that_was_announced_is_known_with_its_length() -> None:
    heart = Heartbeat()
    assert heart.silence(1000.0, 0.0) is None, "it never gave a sign of life"
    for heard, patience in ((10.0, 5.0), (20.0, 90.0), (99.0, 5.0)):
        heart.hear(heard, patience, 0.0)
        assert heart.silence(heard + patience - 0.1, 0.0) is None
        assert heart.silence(heard + patience + 1.0, 0.0) == patience + 1.0


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


@pytest.mark.parametrize(
    ("limits", "deaths", "was_up", "delays"),
    [
        (RestartLimits(), (0.0, 0.3, 0.8, 1.7, 3.4), False, [0.2, 0.4, 0.8, 1.6, None]),
        (RestartLimits(), [61.0 * n for n in range(20)], False, [0.2] * 20),
        (RestartLimits(), [3.0 * n for n in range(20)], True, [0.2] * 20),
        # The first is forgotten by the third; the second is just young enough for the fourth.
        (RestartLimits(1.0, deaths=3, window=10.0), (0, 6, 12, 16), False, [1.0, 2.0, 2.0, None]),
    ],
    ids=["at once", "now and then", "up each time", "beyond the window"],
)
def test_delays_double_until_too_many_deaths_within_the_window_end_the_attempts(
    limits: RestartLimits, deaths: Sequence[float], was_up: bool, delays: list[float | None]
) -> None:
    policy = RestartPolicy(limits)
    assert [policy.on_death(time, was_up=was_up) for time in deaths] == delays


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
