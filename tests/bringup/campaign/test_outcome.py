"""A run's result against the success that a campaign asks for."""

from __future__ import annotations

from typing import Any

import pytest

from arjuna_core.config import dotted
from bringup.campaign.outcome import figures_of, judged


@pytest.mark.parametrize(
    ("result", "success", "lacks"),
    [
        ({"ok": True}, {"ok": True}, ""),
        ({"ok": False}, {"ok": True}, "ok False, not True"),
        ({"ok": True}, {"ok": False}, "ok True, not False"),
        ({"end": "home"}, {"end": "home"}, ""),
        ({}, {"end": "home"}, "end None, not home"),
        ({"n": 3}, {"n": {"at_least": 3, "at_most": 3}}, ""),
        ({"n": 2}, {"n": {"at_least": 3}}, "n 2, not at least 3"),
        ({"n": 4}, {"n": {"at_most": 3}}, "n 4, not at most 3"),
        ({"n": "many"}, {"n": {"at_least": 3}}, "n many, not at least 3"),
        ({"a": 1, "b": 1}, {"a": 2, "b": 2}, "a 1, not 2; b 1, not 2"),
    ],
)
def test_a_result_is_judged_key_by_key(
    result: dict[str, Any], success: dict[str, Any], lacks: str
) -> None:
    assert judged(result, success) == lacks


def test_numbers_and_truths_of_a_result_are_its_figures() -> None:
    flat = dotted({"a": {"b": 1, "c": {"d": True}}, "e": [1], "f": "text"})
    assert figures_of(flat) == {"a.b": 1.0, "a.c.d": 1.0}
