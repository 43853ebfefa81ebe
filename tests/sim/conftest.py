"""Fixtures of the simulator's tests."""

from __future__ import annotations

import pytest


@pytest.fixture
def without_sills(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a check find no sill: the drives across some take most of its time."""
    monkeypatch.setattr("arjuna_sim.check.crossed_sill", lambda robot, empty: None)
