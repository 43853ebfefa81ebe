"""Claims: a robot survives random messages on everything; `bench messages` sends 20 000."""

from __future__ import annotations

import io
from pathlib import Path

import pytest

from tests.fuzz.barrage import STACKS, Barrage

pytestmark = [pytest.mark.ros, pytest.mark.system]
COUNT = 80


@pytest.mark.parametrize("stack", STACKS)
def test_random_messages_leave_a_robot_that_reaches_its_next_goal(
    stack: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # what a request saves is saved there
    log = io.StringIO()
    barrage = Barrage(stack, seed=11, log=log)
    try:
        barrage.run(COUNT)
        assert len(log.getvalue().splitlines()) == COUNT
        assert len(barrage.targets) > 200
        barrage.mend()
        assert barrage.reaches_a_goal()
        tallies = barrage.tallies()
        assert not tallies["failed"]
        assert len(tallies["refused"]) > 10
    finally:
        barrage.robot.close()
