"""A check of the doctor is added by docs/extending.md alone."""

from __future__ import annotations

import inspect
from dataclasses import replace
from pathlib import Path

import pytest

from bringup.doctor import checks, report
from bringup.doctor.checks import body
from bringup.doctor.snapshot import Robot, Snapshot
from tests.helpers.extending import files_of


@pytest.fixture
def flying(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Write the file that the page names: that of the body with other words."""
    (named,) = files_of("A check of the doctor")
    assert named == Path(inspect.getfile(body))
    code = named.read_text(encoding="utf-8")
    code = code.replace("height < lowest", "height > lowest").replace("-0.03", "1.0")
    (tmp_path / "flying.py").write_text(code.replace("sinks into", "is above"), encoding="utf-8")
    monkeypatch.setattr(checks, "__path__", [*checks.__path__, str(tmp_path)])
    monkeypatch.setattr("bringup.doctor.report.CHECKS", checks.find())


@pytest.mark.usefixtures("flying")
def test_a_new_check_is_made_in_its_order() -> None:
    assert list(checks.find())[-4:-2] == ["body", "flying"]
    found = report.diagnose(replace(Snapshot(), robot=Robot(height=2.0)))
    assert [each.what for each in found["flying"]] == ["the robot is above the ground (2.00 m)"]
    assert found["body"] == []
