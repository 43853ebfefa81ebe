"""Claims: AMCL's benchmarks run and say what they promise, and its bars hold on a short tour."""

from __future__ import annotations

import argparse
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.bench import amcl, localization
from tests.helpers.clutter import crowded, without_walls
from tests.helpers.tours import TourWorld, with_odometry


def measured(module: ModuleType, *argv: str) -> dict[str, Any]:
    parser = argparse.ArgumentParser()
    module.add_arguments(parser)
    result: dict[str, Any] = module.run(parser.parse_args(argv))
    return result


def test_localization_is_exact_and_finds_itself_in_the_office(
    capsys: pytest.CaptureFixture[str],
) -> None:
    options = ("--worlds", "office", "--seeds", "2", "--seconds", "12")
    result = measured(localization, *options, "--starts", "6", "--kidnaps", "3")
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
    (row,) = measured(amcl, "--budget", "0.01")["rows"]
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
