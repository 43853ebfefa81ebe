"""`params` on the real nodes: what it dumps loads, and a file's mistakes come all at once."""

from __future__ import annotations

from pathlib import Path

import pytest

from bringup import cli
from bringup.cli_parser import parse
from bringup.parameters.checking import check_file
from bringup.stack import all_nodes


def test_all_parameters_dumped_load_again_and_change_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(parse(["params", "dump"])) == 0
    path = tmp_path / "all.yaml"
    path.write_text(capsys.readouterr().out, encoding="utf-8")
    assert all(f"/{spec.name}:\n" in path.read_text() for spec in all_nodes())
    assert check_file(path).refused_by(strict=True) == []
    assert cli.run(parse(["params", "diff", str(path)])) == 0


def test_a_difference_is_shown_with_both_values(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.yaml"
    path.write_text("amcl: {ros__parameters: {max_beams: 90}}")
    assert cli.run(parse(["params", "diff", str(path)])) == 1
    assert capsys.readouterr().out == "amcl: max_beams: 60 -> 90\n"


def test_an_unknown_node_is_refused_with_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(parse(["params", "dump", "amclx"])) == cli.REFUSED
    assert "no node 'amclx'; did you mean 'amcl'?" in capsys.readouterr().err
