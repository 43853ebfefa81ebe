"""Claims: a robot reaches its goals after hostile transforms; `bench attack` has 200 sessions."""

from __future__ import annotations

import pytest

from tests.fuzz.transforms import Sessions

pytestmark = [pytest.mark.ros, pytest.mark.system]


def test_a_goal_is_reached_after_every_session_of_hostile_transforms() -> None:
    sessions = Sessions()
    assert sessions.run(range(40, 45)) == []
    assert sessions.refused > 100
