"""The navigator where the robot's place or what is round it is not known for a while."""

from __future__ import annotations

import pytest

from arjuna_nav.commands import (
    ComputePath,
    Ending,
    Finish,
    Stop,
)
from arjuna_nav.controllers.base import ControlStatus
from arjuna_nav.navigator import Navigator, NavigatorConfig
from arjuna_nav.planners.base import PlanStatus
from tests.helpers.nav.navigator_script import (
    GOAL,
    STRAIGHT,
    Script,
    failed,
    followed,
    no_plan,
    planned,
)


@pytest.mark.parametrize("status", [ControlStatus.TF_ERROR, ControlStatus.CONTROLLER_TIMED_OUT])
def test_an_outage_is_stood_through(status: ControlStatus) -> None:
    script = Script()
    script.follow()
    for _ in range(5):
        assert script.tick(follow=failed(status)) == [Stop()]
        assert status.name in script.navigator.trouble(script.now)
        assert script.tick(0.9) == []
        assert script.tick(0.2) == [ComputePath((GOAL,))]
        assert followed(script.tick(plan=planned())) is STRAIGHT
    script.tick(3.0)
    assert script.navigator.trouble(script.now) == ""
    assert script.navigator.recoveries == 0


@pytest.mark.parametrize("status", [ControlStatus.TF_ERROR, PlanStatus.TF_ERROR])
def test_an_outage_that_lasts_ends_the_goal_with_its_reason(status: int) -> None:
    script = Script(Navigator(NavigatorConfig(outage_patience=4.0), (GOAL,), start=0.0))
    script.tick()
    end = script.tick()
    while script.now < 20.0 and not any(isinstance(each, Finish) for each in end):
        if status == PlanStatus.TF_ERROR:
            end = script.tick(1.1, plan=no_plan(PlanStatus.TF_ERROR))
        elif followed(script.tick(1.1, plan=planned())) is not None:
            end = script.tick(follow=failed(ControlStatus.TF_ERROR))
    assert end == [Finish(Ending.ABORTED, int(status), "TF_ERROR")]
    assert 4.0 < script.now < 8.0
