"""`doctor`, `tf` and `top` where no robot runs: they end, and say so."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import pytest

from bringup import cli
from bringup.cli import parse
from bringup.commands.tools import tf
from bringup.ros2 import discovery


@pytest.fixture(autouse=True)
def _alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
    monkeypatch.setattr(discovery, "SILENT", 0.2)
    monkeypatch.setattr(tf, "run", partial(tf.run, patience=0.2))


def test_doctor_names_the_range_that_keeps_it_alone(capfd: pytest.CaptureFixture[str]) -> None:
    assert cli.run(parse(["doctor", "--json", "--duration", "0.1"])) == 1
    document = json.loads(capfd.readouterr().out)
    assert any("no process sees another" in item["what"] for item in document["findings"])
    assert document["snapshot"]["nodes"] == []


def test_tf_says_that_no_frame_came(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    picture = tmp_path / "tree.png"
    assert cli.run(parse(["tf", "--duration", "0.1", "--picture", str(picture)])) == 1
    assert "no frame on /tf" in capfd.readouterr().out
    assert not picture.exists()


def test_top_ends_after_the_tables_that_were_asked_for(capfd: pytest.CaptureFixture[str]) -> None:
    assert cli.run(parse(["top", "--count", "2", "--period", "0.1"])) == 1
    assert capfd.readouterr().out.count("no robot runs") == 2
