"""Claims: a participant of another host is answered where the robot has been opened, else not."""

from __future__ import annotations

import pytest

from tests.fuzz.forged import attack

pytestmark = [pytest.mark.ros, pytest.mark.system]


@pytest.mark.parametrize(("discovery_range", "answers"), [("", False), ("SUBNET", True)])
def test_only_an_open_robot_answers_another_host(discovery_range: str, answers: bool) -> None:
    count = attack(discovery_range)
    if isinstance(count, str):
        pytest.skip(count)
    assert (count > 0) == answers, count
