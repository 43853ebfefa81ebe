"""What a trial on level ground finds of robots that stand, drive, stop or turn badly."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from arjuna_sim.check import check
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.world_file import load_world
from arjuna_sim.trial import Trial
from tests.sim.builders import EMPTY as EMPTY_FILE
from tests.sim.files.test_robots import FOUR, INERTIAL, TWO, _load, _robot
from tests.sim.generated import Chassis
from tests.sim.robot_files.tags import fixed, plugin, sides

EMPTY = load_world(EMPTY_FILE)


def _topped(x: float) -> str:
    """Return a robot of one axle 0.1 m ahead, with a weight at some x high above it."""
    top = f"<link name='top'>{INERTIAL.format(9)}</link>{fixed('base', 'top', f'{x} 0 0.3')}"
    return TWO + top


def test_robots_that_do_as_commanded_have_nothing_told(tmp_path: Path) -> None:
    for robot in (Chassis().robot(), _load(tmp_path, FOUR), _load(tmp_path, _topped(0.0))):
        trial = Trial(robot, EMPTY)
        assert (trial.leans, trial.lags) == ((), ())


def test_a_robot_whose_weight_stands_over_its_axle_leans_as_it_stops(tmp_path: Path) -> None:
    trial = Trial(_load(tmp_path, _topped(0.09)), EMPTY)
    assert any("degrees as it stops: its weight is too high, or too near" in n for n in trial.leans)
    found = check(_robot(tmp_path, _topped(0.09)), SearchPath(), {})
    assert "neither slips nor tips" not in found.text()
    assert {note.text for note in found.notes} >= {*trial.leans}
    assert "neither slips nor tips" in check(_robot(tmp_path, TWO), SearchPath(), {}).text()


@pytest.mark.parametrize(("ends", "told"), [(("rear", "front"), False), (("rear",), True)])
def test_wheels_that_nothing_drives_hold_a_robot_as_it_turns(
    tmp_path: Path, ends: tuple[str, ...], told: bool
) -> None:
    grips = "".join(
        f"<gazebo reference='front_{side}_wheel'><mu1>1.0</mu1></gazebo>"
        for side in ("left", "right")
    )
    text = FOUR + plugin("libgazebo_ros_diff_drive.so", sides(*ends)) + grips
    trial = Trial(_load(tmp_path, text), EMPTY)
    assert trial.leans == ()
    assert [" of 90 degrees on the spot: what it stands on" in t for t in trial.lags] == [
        True
    ] * told


def test_what_rubs_holds_a_robot_as_it_drives() -> None:
    rubbing = Chassis(axles=1, casters=2, friction=0.2, rubs=2.0)
    (told,) = Trial(rubbing.robot(), EMPTY).lags
    assert told.endswith(
        " % of the way commanded: what it stands on besides its driven wheels holds it,"
        " or these slip"
    )
    raised = dataclasses.replace(rubbing, rubs=0.0, friction=1.0)
    assert Trial(raised.robot(), EMPTY).lags == ()
