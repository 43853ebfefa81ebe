"""Parameters: dumped, documented, tuned, described."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from arjuna_core.files.shipped import shipped_file
from bringup import cli
from bringup.cli import parse
from bringup.parameters.checking import check_file
from bringup.processes.host import Host
from bringup.stack import DEMO_GROUPS, Group, all_nodes
from bringup.tuning.plan import known_parameters, load_tuning
from scripts.reference import FOLDER, parameters, topics


def test_dumped_parameters_load_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(parse(["params", "dump"])) == 0
    path = tmp_path / "all.yaml"
    path.write_text(capsys.readouterr().out, encoding="utf-8")
    assert all(f"/{spec.name}:\n" in path.read_text() for spec in all_nodes())
    assert check_file(path).refused_by(strict=True) == []
    assert cli.run(parse(["params", "diff", str(path)])) == 0


def test_a_difference_has_both_values(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.yaml"
    path.write_text("amcl: {ros__parameters: {max_beams: 90}}")
    assert cli.run(parse(["params", "diff", str(path)])) == 1
    assert capsys.readouterr().out == "amcl: max_beams: 60 -> 90\n"


def test_an_unknown_node_is_refused_with_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(parse(["params", "dump", "amclx"])) == cli.REFUSED
    assert "no node 'amclx'; did you mean 'amcl'?" in capsys.readouterr().err


REMEDY = "run: python -m scripts.reference"


def test_the_page_of_parameters_is_current() -> None:
    assert (FOLDER / "parameters.md").read_text(encoding="utf-8") == parameters.page(), REMEDY


def test_the_page_of_topics_is_current() -> None:
    assert (FOLDER / "topics.md").read_text(encoding="utf-8") == topics.page(), REMEDY


@pytest.mark.parametrize("path", sorted(shipped_file("campaigns/tuning").glob("*.yaml")), ids=str)
def test_a_shipped_tuning_loads(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    tuning = load_tuning(path, known_parameters)
    assert tuning.dimensions
    assert all(shipped_file(file).exists() for file in tuning.params)


MEASURES = re.compile(
    r"(_time|_timeout|_duration|_distance|_radius|_frequency|_rate|_angle|_vel|_velocity|_period)$"
)


@pytest.mark.parametrize("group", DEMO_GROUPS, ids=lambda group: group.name)
def test_every_parameter_is_described(group: Group, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
    host = Host(group, {})
    described, bare = {}, []
    for node in (*host.nodes, host.manager, host.process.node):
        for name, parameter in node.get_parameters_by_prefix("").items():
            text = described[f"{node.get_name()}.{name}"] = node.describe_parameter(
                name
            ).description
            if MEASURES.search(name) and isinstance(parameter.value, float) and "[" not in text:
                bare.append(f"{node.get_name()}.{name}")
    host.stop()
    host.run()
    assert len(described) > len(host.nodes)
    assert [name for name, text in described.items() if not text.strip()] == []
    assert bare == []
