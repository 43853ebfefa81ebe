"""The table: what each node mainly publishes, what its process uses, what it warned of."""

from __future__ import annotations

from bringup.client.endpoint import Endpoint
from bringup.doctor.machine import HostProcess
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
