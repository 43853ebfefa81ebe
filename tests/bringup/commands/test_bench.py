"""`bench NAME`: found by name, own options, numbers written as JSON."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from arjuna_core.errors import InputFileError
from bringup.commands import bench

SOURCE = """
def add_arguments(parser):
    parser.add_argument("--factor", type=int, default=1)

def run(arguments):
    return {"answer": 21 * arguments.factor}
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A checkout with one benchmark, `toy`."""
    folder = tmp_path / "tests" / "bench"
    folder.mkdir(parents=True)
    (folder / "toy.py").write_text(SOURCE)
    monkeypatch.setattr(bench, "_FOLDER", folder)
    monkeypatch.setattr("tests.bench.__path__", [str(folder)])
    return folder


def test_a_benchmark_takes_its_own_options_and_writes_its_numbers(folder: Path) -> None:
    assert bench.names() == ["toy"]
    bench.measure("toy", ["--factor", "2", "--json", str(folder / "new" / "x.json")])
    assert json.loads((folder / "new" / "x.json").read_text()) == {"answer": 42}


@pytest.mark.usefixtures("folder")
def test_an_unknown_benchmark_is_refused_with_the_nearest() -> None:
    with pytest.raises(InputFileError, match="no such benchmark; did you mean 'toy'"):
        bench.measure("toyy", [])


def test_a_missing_checkout_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench, "_FOLDER", tmp_path / "none")
    with pytest.raises(InputFileError, match="they come with a checkout"):
        bench.measure("toy", [])
