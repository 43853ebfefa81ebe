from __future__ import annotations

import argparse
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from tests.bench import loops, posegraph, scanmatch, slam
from tests.slam.logs.test_offline import text

SQUARE = """\
VERTEX_SE2 0 0 0 0
VERTEX_SE2 1 1.1 0 1.5
VERTEX_SE2 2 1 0.9 3.2
VERTEX_SE2 3 0 1 4.8
EDGE_SE2 0 1 1 0 1.5707963267948966 1 0 0 1 0 1
EDGE_SE2 1 2 1 0 1.5707963267948966 1 0 0 1 0 1
EDGE_SE2 2 3 1 0 1.5707963267948966 1 0 0 1 0 1
EDGE_SE2 3 0 1 0 1.5707963267948966 1 0 0 1 0 1
"""


def run(module: ModuleType, *argv: str) -> dict[str, Any]:
    parser = argparse.ArgumentParser()
    module.add_arguments(parser)
    result: dict[str, Any] = module.run(parser.parse_args(argv))
    return result


def test_a_consistent_graph_is_solved_to_nothing(tmp_path: Path) -> None:
    (tmp_path / "square.g2o").write_text(SQUARE, encoding="utf-8")
    result = run(posegraph, "--g2o", str(tmp_path / "square.g2o"))
    assert result["start_chi2"] > 0.01
    assert result["chi2"] < 1e-9
    assert result["time_s"] > 0.0
    assert result["splu_difference"] < 1e-6


def test_made_scans_are_matched_to_millimetres() -> None:
    result = run(scanmatch, "--count", "3")
    assert result["position_m"] < 0.005
    assert result["failed"] == 0.0


def test_a_log_is_measured_against_its_relations(tmp_path: Path) -> None:
    (tmp_path / "drive.clf").write_text("".join(text()), encoding="utf-8")
    (tmp_path / "drive.relations").write_text("100 110 1 0 0 0 0 0\n", encoding="utf-8")
    log, relations = str(tmp_path / "drive.clf"), str(tmp_path / "drive.relations")
    result = run(slam, "--log", log, "--relations", relations)
    assert result["scans"] == 20
    assert result["translation_m"] < 0.01
    assert result["realtime_factor"] == pytest.approx(result["log_s"] / result["time_s"])
    assert result["callback_worst_ms"] >= result["callback_p99_ms"] >= result["callback_p50_ms"]
    assert run(slam, "--log", log)["translation_m"] is None


def test_a_corrected_log_is_measured_with_made_up_drift(tmp_path: Path) -> None:
    (tmp_path / "drive.clf").write_text("".join(text()), encoding="utf-8")
    trial = run(loops, "--count", "1", "--corrected", "--log", str(tmp_path / "drive.clf"))
    assert trial["trials"][0]["kind"] == "drive"
    assert trial["trials"][0]["scans"] < 20
    assert trial["ate_m"] < 0.05


def test_a_building_is_measured() -> None:
    result = run(loops, "--count", "1", "--largest", "0.1", "--length", "60")
    assert result["trials"][0]["kind"] == "rings"
    assert result["trials"][0]["length_m"] == pytest.approx(60.0, rel=0.3)
    assert result["trials"][0]["ate_m"] < 0.3
    assert 0.0 <= result["agree_worst"] <= result["agree"] <= 1.0
