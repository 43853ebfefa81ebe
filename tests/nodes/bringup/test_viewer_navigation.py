"""Claims: a person reads how navigation goes, why it failed, and how the nodes are."""

from __future__ import annotations

from bringup.viewing.robot.managed import nodes_text
from bringup.viewing.robot.navigation import Navigation

DRIVING = Navigation("driving", 2.345, 12.4, 1)


def test_driving_says_how_far_and_how_often_it_recovered() -> None:
    assert DRIVING.text() == "**driving** · 2.35 m to go · 12 s, recoveries: 1"


def test_a_failure_says_why_and_no_distance() -> None:
    state = DRIVING.ended(6, 204, "no valid path")
    assert state.text() == "**failed** · 12 s, recoveries: 1\n\n⚠ no valid path"


def test_a_failure_without_words_says_its_code() -> None:
    assert Navigation().ended(6, 204, "").error == "error code 204"


def test_arrival_has_no_error() -> None:
    assert Navigation("driving").ended(4, 0, "").text() == "**arrived**"


def test_nodes_are_listed_by_name_with_their_states() -> None:
    rows = nodes_text(
        {"planner": "inactive", "amcl": "active", "x": "errorprocessing"},
        {"amcl": 0.25, "sim": 1.0},
    )
    assert rows.splitlines()[2:] == [
        "| ● | amcl | active | 25% |",
        "| ○ | planner | inactive |  |",
        "|  | sim |  | 100% |",
        "| ✖ | x | errorprocessing |  |",
    ]
    assert nodes_text({}) == "no managed nodes found"
