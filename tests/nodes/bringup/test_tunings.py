"""The shipped tunings name parameters that there are, in ranges that hold the values of now."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.files.shipped import shipped_file
from bringup.tuning.plan import load_tuning
from bringup.tuning.space import known_parameters


@pytest.mark.parametrize("path", sorted(shipped_file("campaigns/tuning").glob("*.yaml")), ids=str)
def test_a_shipped_tuning_loads(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    tuning = load_tuning(path, known_parameters)
    assert tuning.dimensions
    assert all(shipped_file(file).exists() for file in tuning.params)
