"""`calibrate` writes files that the simulator reads."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.config import load
from arjuna_sim.config import SimulatorConfig
from bringup.cli import REFUSED
from bringup.cli import run as run_cli
from bringup.cli_parser import parse
from bringup.offline.calibration import write_calibration
from bringup.parameters.files import for_node, load_parameters


def test_calibrate_writes_parameters_a_snippet_and_a_picture(tmp_path: Path) -> None:
    out = tmp_path / "new" / "folder"
    report = write_calibration(None, None, out)
    assert "within 2% and 4%: yes" in report
    values = for_node(load_parameters([out / "calibration.yaml"]), "sim")
    config = load(SimulatorConfig, values, "sim")
    assert config.drive.effective_track_width == pytest.approx(0.603, rel=0.01)
    assert config.odometry.angular_noise > 0.0
    assert "<effectiveTrackWidth>0.6" in (out / "calibration.urdf.xml").read_text()
    assert (out / "calibration.png").read_bytes().startswith(b"\x89PNG")


def test_a_missing_robot_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    missing = tmp_path / "no.urdf"
    code = run_cli(parse(["calibrate", "--robot", str(missing), "--out", str(tmp_path)]))
    assert code == REFUSED
    assert "no.urdf" in capsys.readouterr().err
