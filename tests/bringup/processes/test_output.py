"""A run as text for a person and as JSON for a program."""

from __future__ import annotations

import json
from collections.abc import Iterator
from datetime import datetime, timezone
from pathlib import Path

import pytest

from bringup.processes.output import JsonOutput, TextOutput
from bringup.processes.run_log import RunLog
from bringup.processes.status import StartUp, event_line

WARNING = "[WARN] [1.5] [amcl]: lost"


@pytest.fixture
def log(tmp_path: Path) -> Iterator[RunLog]:
    log = RunLog("nav", datetime(2026, 1, 1, tzinfo=timezone.utc), tmp_path)
    yield log
    log.close()


def test_json_has_an_object_for_each_state_and_each_line(
    log: RunLog, capsys: pytest.CaptureFixture[str]
) -> None:
    output = JsonOutput(StartUp(["nav"], 0.0), log)
    output.state("nav", "started")
    output.line("nav", event_line(node="amcl", state="active"))
    output.line("nav", WARNING)
    output.line("nav", event_line(waiting=""))
    output.tick()
    shown = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert all(each.pop("time") > 0.0 for each in shown)
    assert shown[:3] == [
        {"process": "nav", "state": "started"},
        {"process": "nav", "node": "amcl", "state": "active"},
        {"process": "nav", "level": "warn", "text": WARNING},
    ]
    assert (shown[4]["process"], shown[4]["state"]) == ("bringup", "active")


def test_in_a_pipe_text_is_plain_and_events_are_not_shown(
    log: RunLog, capsys: pytest.CaptureFixture[str]
) -> None:
    output = TextOutput(StartUp(["nav"], 0.0), log)
    output.line("nav", event_line(node="amcl", state="active"))
    output.line("nav", WARNING)
    output.line("nav", event_line(waiting=""))
    output.tick()
    warning, active = capsys.readouterr().out.splitlines()
    assert warning == f"[nav] {WARNING}"
    assert active.startswith("[bringup] 1 nodes active after ")
    assert log.path is not None
    assert WARNING in log.path.read_text()


def test_on_a_terminal_levels_have_colours_and_progress_is_the_last_line(
    log: RunLog, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    monkeypatch.delenv("NO_COLOR", raising=False)
    output = TextOutput(StartUp(["nav"], 0.0), log)
    output.state("nav", "started")
    output.line("nav", WARNING)
    output.line("nav", event_line(node="amcl", state="active"))
    output.line("nav", event_line(waiting=""))
    shown = capsys.readouterr().out
    assert f"\033[33m[nav] {WARNING}\033[0m\n" in shown
    assert "waiting for nav: imports its nodes" in shown.split("\n")[1]
    assert shown.endswith("\r\033[K")
