"""Who stops walking, when, and who steps over: against numbers and a plain loop."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest

from arjuna_sim.physics.walkers import Manners

STEP = 0.004


class Scales:
    """Boxes that lie on walkers, pressing as gravity says.

    Args:
        gravity: Of each box's weight [m/s^2].
        masses: Of the box on each walker [kg].
    """

    def __init__(self, gravity: float, masses: tuple[float, ...] = (2.0,)) -> None:
        bodies = "".join(
            f"<body mocap='true' pos='{3 * i} 0 0'>"
            "<geom type='box' size='1 1 0.5' mass='0'/></body>"
            f"<body pos='{3 * i} 0 0.75'><freejoint/><geom type='box' size='.25 .25 .25'"
            f" mass='{mass}'/></body>"
            for i, mass in enumerate(masses)
        )
        text = (
            f"<option timestep='{STEP}' gravity='0 0 {-gravity}'/><worldbody>{bodies}</worldbody>"
        )
        self.model = mujoco.MjModel.from_xml_string(f"<mujoco>{text}</mujoco>")
        self.data = mujoco.MjData(self.model)
        self.manners = Manners(self.model, list(range(len(masses))), STEP)
        self.usual = self.model.geom_solref.copy()

    def settle(self) -> None:
        """Let the boxes come to rest."""
        for _ in range(200):
            mujoco.mj_step(self.model, self.data)

    def stopped(self) -> list[int]:
        """Step once, and return who stops."""
        mujoco.mj_step(self.model, self.data)
        return list(map(int, self.manners.stopped(self.data)))

    def until(self, stop: bool) -> int:
        """Step until somebody stops, or goes on; return how many steps it took."""
        for count in range(1000):
            if bool(self.stopped()) is stop:
                return count
        raise AssertionError("nothing has changed")

    def lift(self, box: int) -> None:
        """Take a box off its walker."""
        self.data.qpos[7 * box + 2] += 5000.0


@pytest.mark.parametrize("mass", [0.5, 2.0, 80.0])
def test_a_push_is_by_the_mass_of_what_is_pushed_averaged_over_a_twentieth(mass: float) -> None:
    scales = Scales(60.0, (mass,))
    scales.settle()
    share = STEP / 0.05
    # 60 (1 - (1 - share)^n) > 50
    first = math.ceil(math.log(1.0 - 50.0 / 60.0) / math.log(1.0 - share))
    found = [scales.stopped() for _ in range(first + 1)]
    assert found[: first - 1] == [[]] * (first - 1)
    assert found[first:] == [[0]]


def test_what_tyres_hold_stops_nobody() -> None:
    scales = Scales(49.0)
    scales.settle()
    assert all(scales.stopped() == [] for _ in range(300))


def test_who_waited_two_seconds_presses_lightly_until_nothing_is_there() -> None:
    scales = Scales(60.0)
    scales.settle()
    scales.until(True)
    assert scales.until(False) == round(2.0 / STEP) - 2
    own = np.flatnonzero(scales.model.geom_bodyid == 1)
    others = np.flatnonzero(scales.model.geom_bodyid != 1)
    assert (scales.model.geom_solref[own, 0] == 1.0).all()
    assert (scales.model.geom_solref[others] == scales.usual[others]).all()
    assert (scales.model.geom_solref[own, 1] == scales.usual[own, 1]).all()
    assert all(scales.stopped() == [] for _ in range(20))
    scales.lift(0)
    assert scales.stopped() == []
    assert (scales.model.geom_solref == scales.usual).all()


def test_who_is_let_go_has_forgotten() -> None:
    scales = Scales(60.0)
    scales.settle()
    scales.until(True)
    scales.lift(0)
    assert scales.stopped() == []
    scales.lift(0)
    for _ in range(3):
        assert scales.stopped() == []


def test_walkers_are_judged_each_alone() -> None:
    """Of three one meets nothing, one what it must not push, one is let go meanwhile."""
    scales = Scales(60.0, (1.0, 5.0, 2.0))
    scales.lift(0)
    scales.settle()
    scales.lift(0)
    scales.until(True)
    assert scales.stopped() == [1, 2]
    scales.lift(2)
    assert scales.stopped() == [1]
    usual = scales.usual[:, 0]
    scales.until(False)
    changed = np.flatnonzero(scales.model.geom_solref[:, 0] != usual)
    assert scales.model.geom_bodyid[changed].tolist() == [3]


def test_what_is_heavier_counts_where_two_things_are_one() -> None:
    """What is pushed weighs all that hangs on it, not its own link alone."""
    text = f"""<mujoco><option timestep='{STEP}' gravity='0 0 -60'/><worldbody>
    <body mocap='true'><geom type='box' size='1 1 0.5' mass='0'/></body>
    <body pos='0 0 0.75'><freejoint/><geom type='box' size='.25 .25 .25' mass='1'/>
    <body pos='0 0 0.4'><geom type='box' size='.1 .1 .1' mass='9'/></body></body>
    </worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    for _ in range(200):
        mujoco.mj_step(model, data)
    manners = Manners(model, [0], STEP)
    found = []
    for _ in range(40):
        mujoco.mj_step(model, data)
        found.append(len(manners.stopped(data)))
    assert 19 <= found.index(1) <= 23  # 21, as of a single body of 10 kg
