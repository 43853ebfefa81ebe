"""One log file a run, and not too many runs."""

from __future__ import annotations

from datetime import datetime, timedelta, timezone
from pathlib import Path

from bringup.processes.run_log import RUNS_KEPT, RunLog

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
