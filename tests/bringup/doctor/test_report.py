"""The report: a line and a remedy for each finding, and JSON with the facts behind it."""

from __future__ import annotations

import json

from bringup.doctor.report import ROWS, as_json, diagnose, guides_page, page
from bringup.doctor.snapshot import Machine, Robot, Snapshot

FULL = Snapshot(
    machine=Machine(disk_free=0.1),
    domain=4,
    nodes=("/sim",),
    robot=Robot(log=(("planner_server", "the goal is in an obstacle"),)),
)


def test_the_page_has_each_finding_with_its_remedy_and_what_was_said() -> None:
    text = page(FULL, diagnose(FULL))
    assert text.startswith("domain 4, 1 nodes")
    assert "resources\n  0.1 GiB of disk are free\n    -> free some" in text
    assert "planner_server: the goal is in an obstacle" in text
    assert "resources" not in text.split("\n")[1]


def test_json_has_findings_and_facts() -> None:
    document = json.loads(as_json(FULL, diagnose(FULL)))
    assert [item["check"] for item in document["findings"]] == ["resources"]
    assert document["snapshot"]["machine"]["disk_free"] == 0.1


def test_help_says_what_answers_each_row_of_the_guides_tables() -> None:
    text = guides_page()
    assert all(row in text for row in ROWS)
    assert "velocity: the listeners of /cmd_vel" in text
