"""A run as text for a person and as JSON for a program, and when its start-up is over."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from datetime import datetime, timezone
from pathlib import Path

import pytest

from bringup.processes.output import JsonOutput, RunLog, StartUp, TextOutput, event_line, read_event

WARNING = "[WARN] [1.5] [amcl]: lost"


@pytest.fixture
def log(tmp_path: Path) -> Iterator[RunLog]:
    log = RunLog("nav", datetime(2026, 1, 1, tzinfo=timezone.utc), tmp_path)
    yield log
    log.close()


def test_json_has_objects_and_lines(log: RunLog, capsys: pytest.CaptureFixture[str]) -> None:
    output = JsonOutput(StartUp(["nav"], 0.0), log)
    output.state("nav", "started")
    output.event("nav", {"node": "amcl", "state": "active"})
    output.line("nav", WARNING)
    output.event("nav", {"waiting": ""})
    output.tick()
    shown = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert all(each.pop("time") > 0.0 for each in shown)
    assert shown[:3] == [
        {"process": "nav", "state": "started"},
        {"process": "nav", "node": "amcl", "state": "active"},
        {"process": "nav", "level": "warn", "text": WARNING},
    ]
    assert (shown[4]["process"], shown[4]["state"]) == ("bringup", "active")


def test_piped_text_is_plain(log: RunLog, capsys: pytest.CaptureFixture[str]) -> None:
    output = TextOutput(StartUp(["nav"], 0.0), log)
    output.event("nav", {"node": "amcl", "state": "active"})
    output.line("nav", WARNING)
    output.event("nav", {"waiting": ""})
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
    output.event("nav", {"node": "amcl", "state": "active"})
    output.event("nav", {"waiting": ""})
    shown = capsys.readouterr().out
    assert f"\033[33m[nav] {WARNING}\033[0m\n" in shown
    assert "waiting for nav: imports its nodes" in shown.split("\n")[1]
    assert shown.endswith("\r\033[K")


def test_a_run_does_not_wait_for_a_reader(log: RunLog, monkeypatch: pytest.MonkeyPatch) -> None:
    read, written = os.pipe()
    lines = [f"[WARN] [1.5] [amcl]: {number} {'x' * 5000}" for number in range(40)]
    with os.fdopen(read) as reader, os.fdopen(written, "w") as pipe:
        monkeypatch.setattr("sys.stdout", pipe)
        output = TextOutput(StartUp([], 0.0), log)
        for line in lines:  # more than a pipe holds
            output.line("nav", line)
        output.tick()
        os.set_blocking(read, False)
        shown = reader.read()
        output.tick()
        output.line("nav", "and on")
        end = reader.read().splitlines()
    whole = shown.count("x\n")
    assert shown.startswith(f"[nav] {lines[0]}\n[nav] {lines[1]}\n")
    assert 0 < whole < 40
    assert f"[bringup] {40 - whole} lines that nobody read are left out; log: " in end[-2]
    assert end[-1] == "[nav] and on"
    assert log.path is not None
    assert lines[-1] in log.path.read_text()


def up(start_up: StartUp, name: str, *nodes: str) -> None:
    """Report a process whose nodes are all active."""
    for node in nodes:
        start_up.take(name, {"node": node, "state": "active"})
    start_up.take(name, {"waiting": ""})


def test_events_are_read_as_written_and_log_lines_ignored() -> None:
    event = {"node": "amcl", "state": "active"}
    assert read_event(event_line(**event)) == event
    for line in ("[INFO] [1.0] [amcl]: active", '{"node": "amcl"}', "\x1e{", "\x1e[1]", ""):
        assert read_event(line) is None


def test_it_is_up_when_every_process_has_all_its_nodes_active() -> None:
    start_up = StartUp(["a", "b"], now=10.0)
    up(start_up, "a", "x", "y")
    start_up.take("b", {"node": "z", "state": "inactive"})
    start_up.take("b", {"waiting": "z to activate"})
    assert start_up.waiting == "b: z to activate"
    assert start_up.came_up(12.0) is None
    up(start_up, "b", "z")
    assert start_up.came_up(14.5) == 4.5
    assert start_up.came_up(15.0) is None
    assert start_up.nodes == 3


def test_processes_that_wait_for_the_same_are_named_together() -> None:
    start_up = StartUp(["a", "b"], now=0.0)
    assert start_up.waiting == "a, b: imports its nodes"


def test_what_is_waited_for_is_said_once_after_a_while_and_again_when_it_changes() -> None:
    start_up = StartUp(["a"], now=0.0)
    assert [start_up.overdue(now, 3.0) for now in (0.0, 2.9)] == [None, None]
    assert start_up.overdue(3.0, 3.0) == "a: imports its nodes"
    assert start_up.overdue(9.0, 3.0) is None
    start_up.take("a", {"waiting": "/clock"})
    assert [start_up.overdue(now, 3.0) for now in (9.5, 12.0)] == [None, None]
    assert start_up.overdue(12.5, 3.0) == "a: /clock"


def test_a_process_that_starts_again_counts_its_time_from_then() -> None:
    start_up = StartUp(["a"], now=0.0)
    up(start_up, "a", "x")
    assert start_up.came_up(2.0) == 2.0
    start_up.restarted("a", 20.0)
    assert start_up.waiting
    up(start_up, "a", "x")
    assert start_up.came_up(21.0) == 1.0


def test_nodes_that_a_client_deactivates_later_are_no_start_up() -> None:
    start_up = StartUp(["a"], now=0.0)
    up(start_up, "a", "x")
    start_up.came_up(2.0)
    start_up.take("a", {"node": "x", "state": "inactive"})
    assert start_up.waiting == ""


def test_processes_without_nodes_are_not_waited_for() -> None:
    start_up = StartUp(["a"], now=0.0)
    start_up.restarted("record", 1.0)
    start_up.take("record", {"waiting": "something"})
    up(start_up, "a", "x")
    assert start_up.waiting == ""
