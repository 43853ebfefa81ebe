"""The aggregator: the tree of its usual file, stale and missing statuses, the whole."""

from __future__ import annotations

from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from arjuna_sim.nodes.processing.diagnostics import DiagnosticAggregatorNode
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import start

GENERIC = "diagnostic_aggregator/GenericAnalyzer"
VALUES: dict[str, Any] = {
    "path": "Aggregation",
    "arms": {"type": GENERIC, "path": "Arms", "startswith": ["/arms"], "timeout": 2.0},
    "motors": {"type": GENERIC, "contains": "/motor", "remove_prefix": ["/legs"]},
    "sides": {
        "type": "diagnostic_aggregator/AnalyzerGroup",
        "path": "Sides",
        "analyzers": {"left": {"type": GENERIC, "path": "Left", "expected": ["/gripper/left"]}},
    },
    "quiet": {"type": "diagnostic_aggregator/IgnoreAnalyzer", "regex": ["^log.*"]},
}


def _say(bench: RosBench, *names: str, level: bytes = DiagnosticStatus.OK) -> None:
    statuses = [DiagnosticStatus(name=name, level=level, message="m") for name in names]
    bench.publish(DiagnosticArray, "/diagnostics", DiagnosticArray(status=statuses))


def _levels(message: Any) -> dict[str, int]:
    """Return the levels by name, without the statuses of the process itself."""
    found = {one.name: one.level[0] for one in message.status}
    return {
        name: level
        for name, level in found.items()
        if not name.endswith("messages") and name not in ("/Other", "/Aggregation/Other")
    }


def test_statuses_stand_in_the_tree_of_the_file(bench: RosBench) -> None:
    out = bench.collect(DiagnosticArray, "/diagnostics_agg")
    whole = bench.collect(DiagnosticStatus, "/diagnostics_toplevel_state")
    start(bench, DiagnosticAggregatorNode(bench.process, VALUES))
    _say(bench, "/arms/left", "/legs/motor", "/gripper/left", "log: rotated")
    _say(bench, "/legs/motor", level=DiagnosticStatus.WARN)
    bench.advance(1.0)
    assert _levels(out[-1]) == {
        "/Aggregation/Arms": 0,
        "/Aggregation/Arms/arms left": 0,
        "/Aggregation/motors": 1,
        "/Aggregation/motors/motor": 1,
        "/Aggregation/Sides": 0,
        "/Aggregation/Sides/Left": 0,
        "/Aggregation/Sides/Left/gripper left": 0,
    }
    assert whole[-1].level == DiagnosticStatus.WARN
    (value,) = out[-1].status[0].values
    assert (value.key, value.value) == ("arms left", "m")


def test_what_is_silent_is_stale_and_what_nobody_takes_is_shown(bench: RosBench) -> None:
    out = bench.collect(DiagnosticArray, "/diagnostics_agg")
    whole = bench.collect(DiagnosticStatus, "/diagnostics_toplevel_state")
    start(bench, DiagnosticAggregatorNode(bench.process, {**VALUES, "other_as_errors": True}))
    _say(bench, "/arms/left", "camera")
    bench.advance(3.0)
    _say(bench, "/arms/right")
    bench.advance(1.0)
    levels = _levels(out[-1])
    assert levels["/Aggregation/Arms"] == 2  # one of two is stale
    assert levels["/Aggregation/Arms/arms left"] == 3
    assert levels["/Aggregation/Sides/Left/gripper left"] == 3
    (other,) = (one for one in out[-1].status if one.name == "/Aggregation/Other")
    assert other.level == DiagnosticStatus.ERROR
    assert levels["/Aggregation/Other/camera"] == 0
    assert whole[-1].level == DiagnosticStatus.ERROR


def test_a_number_of_items_is_held_to_and_stale_ones_may_go(bench: RosBench) -> None:
    out = bench.collect(DiagnosticArray, "/diagnostics_agg")
    own = {"type": GENERIC, "name": "a", "num_items": 1, "discard_stale": True, "timeout": 2.0}
    start(bench, DiagnosticAggregatorNode(bench.process, {"one": own}))
    _say(bench, "a")
    bench.advance(1.0)
    assert _levels(out[-1]) == {"/one": 0, "/one/a": 0}
    bench.advance(4.0)
    assert _levels(out[-1]) == {"/one": 2}
    assert out[-1].status[0].message == "Expected 1, found 0"


def test_analyzers_may_stand_below_a_word_and_those_of_a_group_below_none(bench: RosBench) -> None:
    out = bench.collect(DiagnosticArray, "/diagnostics_agg")
    names = {name: {"type": GENERIC, "contains": name, "discard_stale": True} for name in "ab"}
    group = {"type": "diagnostic_aggregator/AnalyzerGroup", "path": "both", **names}
    start(bench, DiagnosticAggregatorNode(bench.process, {"analyzers": {"part": group}}))
    _say(bench, "/a", level=DiagnosticStatus.STALE)  # by its own word
    _say(bench, "/b")
    bench.advance(1.0)
    assert _levels(out[-1]) == {"/both": 0, "/both/a": 0, "/both/b": 0, "/both/b/b": 0}


def test_what_is_worse_is_published_at_once_where_it_is_critical(bench: RosBench) -> None:
    whole = bench.collect(DiagnosticStatus, "/diagnostics_toplevel_state")
    values = {"one": {"type": GENERIC, "contains": "a"}, "critical": True}
    start(bench, DiagnosticAggregatorNode(bench.process, values))
    _say(bench, "a")
    bench.advance(1.0)
    before = len(whole)
    _say(bench, "a", level=DiagnosticStatus.ERROR)
    _say(bench, "a", level=DiagnosticStatus.ERROR)
    bench.advance(0.1)
    assert [one.level for one in whole[before:]] == [DiagnosticStatus.ERROR]
