"""The demo's run, where it cannot go on."""

from __future__ import annotations

import signal
from pathlib import Path
from unittest.mock import Mock

import pytest

from bringup.demo.demo import Demo, DemoOptions
from bringup.lockstep import LockStep, LockStepError
from bringup.parameters.files import merged, shipped_parameters
from bringup.processes.supervisor import Supervisor
from bringup.terminal import Progress, stopped_by_signals

pytestmark = pytest.mark.ros


def test_a_robot_that_sees_nothing_maps_nothing_and_is_told_soon(tmp_path: Path) -> None:
    text = Path("urdf/arjuna.urdf").read_text(encoding="utf-8")
    file = tmp_path / "blind.urdf"
    file.write_text(text.replace('type="ray"', 'type="altimeter"'), encoding="utf-8")
    values = merged(shipped_parameters(), {"sim": {"robot": str(file)}})
    demo = Demo(DemoOptions(0, tmp_path, values, map_time=1.0, explore_time=9.0), Progress())
    with pytest.raises(LockStepError, match="a scan that shows where the robot is did not come"):
        demo.run()


def test_ctrl_c_that_a_callback_dropped_ends_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bringup.interrupts._seen_at", 0.0)
    with pytest.raises(KeyboardInterrupt, match=r"^$"):
        LockStep.step(Mock())


def test_ctrl_c_that_was_dropped_before_is_the_first(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bringup.interrupts._seen_at", 0.0)
    assert Supervisor([], Mock()).run() == 0
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    assert stopped_by_signals().is_set()
    for number, handler in zip((signal.SIGINT, signal.SIGTERM), before, strict=True):
        signal.signal(number, handler)
