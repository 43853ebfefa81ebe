"""A search space: its meaning, and the mistakes in one."""

from __future__ import annotations

from typing import Any

import pytest

from arjuna_core.param import ParamInfo
from bringup.tuning.space import dimensions_of

_KNOWN = {
    "driver": {
        "speed": (0.5, ParamInfo("Greatest speed.", "m/s", 0.0, 2.0)),
        "count": (100, ParamInfo("Particles.", "", 1, 5000)),
        "model": ("field", ParamInfo("Which model.", choices=("beam", "field"))),
        "regulated": (True, ParamInfo("Whether bends slow down.")),
        "names": (("a",), ParamInfo("A list.")),
    }
}


def _one(key: str, given: Any) -> Any:
    found, problems = dimensions_of({"driver": {key: given}}, _KNOWN)
    return problems[0] if problems else found[0]


def test_ranges_and_choices_are_read_with_the_value_of_now() -> None:
    speed = _one("speed", {"low": 0, "high": 1.5})
    assert (speed.name, speed.now, speed.low, speed.high) == ("driver: speed", 0.5, 0.0, 1.5)
    assert (speed.unit, speed.whole, speed.log) == ("m/s", False, False)
    count = _one("count", {"low": 10, "high": 1000, "log": True})
    assert count.whole
    assert count.log
    assert _one("model", ["beam", "field"]).choices == ("beam", "field")
    assert _one("speed", [0.5, 1]).choices == (0.5, 1)
    assert not _one("regulated", [False, True]).whole


@pytest.mark.parametrize(
    ("key", "given", "problem"),
    [
        ("sped", [1.0], "unknown parameter 'sped'; did you mean 'speed'"),
        ("speed", 0.7, "'speed' is no range; valid: {low, high}"),
        ("speed", {"low": 0.1}, "'speed' is no range"),
        ("speed", {"low": 0.1, "high": 0.7, "step": 1}, "'speed' is no range"),
        ("speed", {"low": "a", "high": 0.7}, "'speed' must be float, got 'a' (str)"),
        ("speed", {"low": 0.9, "high": 0.2}, "low lies below high"),
        ("speed", {"low": 0.0, "high": 0.7, "log": True}, "above 0 for log"),
        ("speed", {"low": 0.1, "high": 9.0}, "'speed' is 9.0; the greatest valid is 2.0 m/s"),
        ("speed", {"low": 0.6, "high": 0.9}, "is 0.5 now, outside 0.6 to 0.9: widen"),
        ("speed", [0.5, 7.0], "'speed' is 7.0; the greatest valid is 2.0 m/s"),
        ("speed", [0.5, True], "'speed' must be float, got True (bool)"),
        ("count", {"low": 1.5, "high": 10}, "'count' must be int, got 1.5 (float)"),
        ("model", ["beam", "laser"], "'model' is 'laser'; valid: beam, field"),
        ("model", ["beam"], "is 'field' now, which its values leave out"),
        ("model", {"low": 0, "high": 1}, "list its values"),
        ("regulated", {"low": 0, "high": 1}, "list its values"),
        ("names", ["a"], "no number, truth or word"),
    ],
)
def test_mistakes_are_named(key: str, given: Any, problem: str) -> None:
    assert problem in _one(key, given)


def test_every_mistake_is_named_at_once() -> None:
    space = {"diver": {"speed": [1.0]}, "driver": {"speed": 1, "cont": [1]}}
    _, problems = dimensions_of(space, _KNOWN)
    assert len(problems) == 3
    assert "no node 'diver'; did you mean 'driver'" in problems[0]


@pytest.mark.parametrize("space", [None, {}, {"driver": {}}, {"driver": 1}, [1]])
def test_a_space_of_nothing_is_refused(space: Any) -> None:
    assert dimensions_of(space, _KNOWN)[1]
