"""Calibration finds the numbers that the shipped robot carries."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_sim.calibration import calibrate
from arjuna_sim.robot import load_robot
from arjuna_sim.simulator import SimulatorConfig
from tests.sim.builders import EMPTY, ROBOT, edited


def test_shipped_numbers_are_what_calibration_finds(tmp_path: Path) -> None:
    uncalibrated = edited(
        ROBOT, tmp_path, "effectiveTrackWidth>0.6094<", "effectiveTrackWidth>0.34<"
    )
    found = calibrate(uncalibrated, EMPTY, SimulatorConfig())
    drive = load_robot(ROBOT).drive
    assert found.track == pytest.approx(drive.effective_track, rel=0.01)
    assert found.radius == pytest.approx(drive.effective_radius, rel=0.002)
