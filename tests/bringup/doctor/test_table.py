"""The doctor's parts: the scan's fit, the machine, tables and reports."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from bringup.client.endpoint import Endpoint
from bringup.doctor.machine import HostProcess, host_processes
from bringup.doctor.report import ROWS, as_json, diagnose, guides_page, page
from bringup.doctor.snapshot import Machine, Robot, Snapshot, scan_facts
from bringup.doctor.table import cpu_shares, groups_by_node, main_topic, rows, table_text


def _ends(*topics: str) -> list[Endpoint]:
    return [Endpoint("/a/sim", topic, "t", True) for topic in topics]


def test_the_main_topic_is_no_plumbing() -> None:
    assert main_topic("/a/sim", _ends("/rosout", "/tf", "/sim/transition_event")) == ""
    assert main_topic("/a/sim", _ends("/tf", "/b", "/a/x")) == "/a/x"


def test_the_main_topic_of_a_node_of_ours_is_known_in_every_namespace() -> None:
    assert main_topic("/a/sim", _ends("/a/clock", "/a/scan")) == "/a/scan"


def test_a_process_s_share_is_what_it_used_between_two_looks() -> None:
    before = [HostProcess(1, "sim", 0, 10.0)]
    after = [HostProcess(1, "sim", 0, 11.0), HostProcess(2, "slam", 0, 5.0)]
    assert cpu_shares(before, after, 2.0) == {"sim": 0.5}


def test_managers_and_hosts_belong_to_their_process() -> None:
    groups = groups_by_node()
    assert groups["lifecycle_manager_sim"] == groups["sim_host"] == groups["sim"] == "sim"
    assert groups["local_costmap"] == "navigation"


def test_a_row_has_all_that_is_known_of_a_node() -> None:
    found = rows(
        ["/local_costmap/local_costmap", "/mine"],
        {"/local_costmap/local_costmap": ""},
        {"navigation": 0.25},
        {"/local_costmap/local_costmap": "/c"},
        {"/c": 5.0},
        {"local_costmap.local_costmap": "no scan"},
    )
    lines = table_text(found, 200).splitlines()
    assert lines[1].split() == [
        *("/local_costmap/local_costmap", "no", "answer", "navigation", "25%", "/c"),
        *("5.0", "Hz", "no", "scan"),
    ]
    assert lines[2] == "/mine"
    assert max(map(len, table_text(found, 40).splitlines())) <= 40


def _room() -> OccupancyGrid:
    """Return a room of 4 x 2 m whose lower left corner is the origin."""
    data = np.zeros((40, 80), dtype=np.int8)
    data[[0, -1], :] = data[:, [0, -1]] = 100
    return OccupancyGrid(GridFrame(0.05, 80, 40), data)


def _scan_at(x: float, y: float, heading: float) -> Scan:
    angles = np.linspace(-np.pi, np.pi, 180, endpoint=False)
    c, s = np.cos(angles + heading), np.sin(angles + heading)
    with np.errstate(divide="ignore"):
        along_x = np.where(c > 0.0, (3.975 - x) / c, (0.025 - x) / c)
        along_y = np.where(s > 0.0, (1.975 - y) / s, (0.025 - y) / s)
    ranges = np.minimum(np.abs(along_x), np.abs(along_y))
    return Scan(ranges, -np.pi, 2.0 * np.pi / 180, 0.1, 10.0)


@pytest.mark.parametrize("pose", [SE2(1.0, 0.5, 0.3), SE2(3.0, 1.5, -2.0)])
def test_from_the_true_pose_every_hit_is_on_a_wall(pose: SE2) -> None:
    scan = _scan_at(pose.x, pose.y, pose.theta)
    assert scan_facts(scan, "l", False, _room(), pose).on_walls == 1.0
    away = SE2(pose.x + 0.5, pose.y - 0.2, pose.theta + 0.8)
    fit = scan_facts(scan, "l", False, _room(), away).on_walls
    assert fit is not None
    assert fit < 0.6


def test_a_scan_of_a_sensor_upside_down_is_mirrored() -> None:
    pose = SE2(1.0, 0.5, 0.3)
    scan = _scan_at(pose.x, pose.y, pose.theta)
    turned_scan = replace(scan, ranges=scan.ranges[::-1].copy(), angle_min=np.pi * (2 / 180 - 1))
    assert scan_facts(turned_scan, "l", True, _room(), pose).on_walls == 1.0
    turned = scan_facts(turned_scan, "l", False, _room(), pose).on_walls
    assert turned is not None
    assert turned < 0.6


def test_without_a_map_or_a_pose_nothing_is_said_of_the_fit() -> None:
    scan = _scan_at(1.0, 0.5, 0.3)
    assert scan_facts(scan, "l", False, None, SE2(1.0, 0.5, 0.3)).on_walls is None
    assert scan_facts(scan, "l", False, _room(), None).on_walls is None


def test_a_map_without_walls_says_nothing_of_the_fit() -> None:
    empty = OccupancyGrid(GridFrame(0.05, 80, 40), np.zeros((40, 80), dtype=np.int8))
    scan = _scan_at(1.0, 0.5, 0.3)
    assert scan_facts(scan, "l", False, empty, SE2(1.0, 0.5, 0.3)).on_walls is None


def test_shares_are_of_all_beams() -> None:
    scan = Scan(np.array([0.02, 1.0, np.inf, np.inf]), 0.0, 0.1, 0.01, 5.0)
    facts = scan_facts(scan, "l", False, None, None)
    assert (facts.returns, facts.near) == (0.5, 0.25)


def _process(proc: Path, pid: int, command: str, environment: str = "") -> None:
    folder = proc / str(pid)
    folder.mkdir()
    (folder / "cmdline").write_bytes(command.replace(" ", "\0").encode())
    (folder / "environ").write_bytes(environment.encode())
    times = "S 1 1 1 0 -1 0 0 0 0 0 250 50 0 0"
    (folder / "stat").write_text(f"{pid} (python (odd)) {times}")


def test_hosts_are_found_with_group_and_domain(tmp_path: Path) -> None:
    host = "python -m bringup.host"
    _process(tmp_path, 12, f"{host} slam --parameters {{}}", "HOME=/\0ROS_DOMAIN_ID=7\0")
    _process(tmp_path, 3, f"{host} sim", "HOME=/\0")
    _process(tmp_path, 4, "python -m bringup sim")
    (tmp_path / "5").mkdir()
    found = host_processes(tmp_path)
    assert [(each.pid, each.group, each.domain) for each in found] == [
        (3, "sim", 0),
        (12, "slam", 7),
    ]
    assert found[0].cpu_time > 0.0


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
