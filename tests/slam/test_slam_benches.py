"""Claims: benches of SLAM and AMCL say what they promise; AMCL's bars hold on a short tour."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.bench import amcl, localization, loops, posegraph, run, scanmatch, slam
from tests.helpers.tours import TourWorld, crowded, with_odometry, without_walls
from tests.slam.logs.test_recording import text

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


def test_localization_is_exact_in_the_office(capsys: pytest.CaptureFixture[str]) -> None:
    options = ("--worlds", "office", "--seeds", "2", "--seconds", "12")
    result = run(localization, *options, "--starts", "6", "--kidnaps", "3")
    assert result["tracking_rmse_m"] <= 0.02
    assert result["tracking_rmse_rad"] <= 0.01
    assert result["tracking_p99_m"] <= 0.05
    assert result["global_success"] == 1.0
    assert result["kidnap_success"] == 1.0
    rows = {row["case"]: row for row in result["rows"]}
    assert rows["crowded"]["rmse_m"] <= 0.04
    assert all(row.get("diverged", 0) == 0 for row in rows.values())
    assert "office" in capsys.readouterr().out


def test_an_update_is_timed_where_there_is_no_peer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(amcl, "_PARTICLES", (250,))
    monkeypatch.setattr(amcl, "_BEAMS", ())
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    (row,) = run(amcl, "--budget", "0.01")["rows"]
    assert (row["particles"], row["beams"], row["amcl_ms"]) == (250, 60, None)
    assert 0.0 < row["best_ms"] <= row["ms"]


def test_clutter_and_poor_odometry_are_what_they_say() -> None:
    world = TourWorld("arjuna_room")
    drive = world.drive(0, 6.0)
    rng = np.random.default_rng(0)
    noisy = with_odometry(drive, "noisy", rng)
    assert noisy[-1].odometry.distance(drive[-1].odometry) > 0.02
    perfect = with_odometry(drive, "perfect", rng)
    moved = drive[0].truth.inverse() @ drive[-1].truth
    by_odometry = perfect[0].odometry.inverse() @ perfect[-1].odometry
    assert by_odometry.distance(moved) < 1e-9
    nearer = [
        (a.scan.ranges < b.scan.ranges - 1e-9).mean()
        for a, b in zip(crowded(world, drive, rng), drive, strict=True)
    ]
    assert 0.01 < np.mean(nearer) < 0.8
    assert without_walls(world.map, rng).occupied().sum() < 0.9 * world.map.occupied().sum()
