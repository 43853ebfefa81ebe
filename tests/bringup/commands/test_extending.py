"""A command is added by docs/extending.md alone."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from arjuna_core.files.maps import load_map
from arjuna_core.files.shipped import shipped_file
from tests.helpers.extending import ROOT, section


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with Arjuna's commands and the page's own."""
    folder = tmp_path_factory.mktemp("checkout")
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "bringup", folder / "bringup", ignore=ignored)
    page = section("A command")
    file = re.search(r"One file, `(.+?)`", page)
    code = re.search(r"```python\n(.+?)```", page, re.DOTALL)
    assert file is not None
    assert code is not None
    (folder / file[1]).write_text(code[1], encoding="utf-8")
    return folder


def bringup(checkout: Path, *words: str) -> str:
    """Return the output of a command of the checkout."""
    run = subprocess.run(
        [sys.executable, "-m", "bringup", *words],
        cwd=checkout,
        env={**os.environ, "COLUMNS": "100"},
        capture_output=True,
        text=True,
        check=True,
    )
    return run.stdout


def test_the_first_page_and_the_help_show_it(checkout: Path) -> None:
    assert "Others:\n  area          print how much free space a map has" in bringup(checkout)
    shown = bringup(checkout, "area", "--help")
    assert "Print how much free space a map has." in shown
    assert "python -m bringup area maps/arjuna_room.yaml" in shown


def test_it_runs(checkout: Path) -> None:
    path = shipped_file("maps/arjuna_room.yaml")
    grid = load_map(path)
    area = grid.free().sum() * grid.frame.resolution**2
    assert area > 10.0
    assert bringup(checkout, "area", str(path)) == f"{area:.1f} m2 are free\n"
