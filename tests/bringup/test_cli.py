"""Errors as the command line prints them."""

from __future__ import annotations

import argparse
import re
from pathlib import Path

import pytest

from bringup import cli

PYPROJECT = Path(__file__).resolve().parents[2] / "pyproject.toml"


def said_without(module: str, capsys: pytest.CaptureFixture[str]) -> str:
    """Return what is said where a command's module is missing."""

    def command(arguments: argparse.Namespace) -> int:
        raise ModuleNotFoundError(f"No module named {module!r}", name=module)

    assert cli.run(argparse.Namespace(run=command)) == cli.REFUSED
    return capsys.readouterr().err


@pytest.mark.parametrize(
    ("module", "extra"),
    [("rerun", "view"), ("rerun.blueprint", "view"), ("optuna", "tune"), ("pyarrow", "campaign")],
)
def test_a_module_of_an_extra_is_named_with_the_words_that_install_it(
    module: str, extra: str, capsys: pytest.CaptureFixture[str]
) -> None:
    said = said_without(module, capsys)
    assert said.startswith(f"error: the module {module} is not installed")
    assert f"'make setup EXTRAS={extra}'" in said


def test_another_module_asks_for_the_whole_set_up(capsys: pytest.CaptureFixture[str]) -> None:
    assert "run 'make setup'\n" in said_without("numba", capsys)


def test_the_extras_are_those_of_the_project() -> None:
    text = PYPROJECT.read_text(encoding="utf-8")
    for module, extra in cli.EXTRAS.items():
        (packages,) = re.findall(rf"^{extra} = \[(.*)\]", text, re.MULTILINE)
        assert re.search(rf'"{module.replace("_", "-")}(-sdk)?"', packages), module
