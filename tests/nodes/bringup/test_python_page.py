"""docs/python.md: every public method stands on it, and its examples run as they are written."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from arjuna import simulate
from arjuna_core.files.shipped import shipped_file
from bringup.client.robot import Robot
from bringup.simulated import SimulatedRobot

PAGE = shipped_file("docs/python.md").read_text(encoding="utf-8")
SECTIONS = dict(
    re.findall(r"^### `(\w+)(?:\(\))?`\n(.*?)(?=^##|\Z)", PAGE, re.MULTILINE | re.DOTALL)
)


def test_every_public_name_has_a_section_with_an_example_that_uses_it() -> None:
    public = {name for cls in (Robot, SimulatedRobot) for name in vars(cls) if name[0] != "_"}
    assert set(SECTIONS) == public | {"Robot", "simulate"}
    for name, section in SECTIONS.items():
        (code,) = re.findall(r"```py(?:thon)?\n(.*?)```", section, re.DOTALL)
        assert re.search(rf"\b{name}\b", code), name


def test_what_it_says_of_arguments_is_so() -> None:
    from inspect import signature

    for name, section in SECTIONS.items():
        found = re.match(rf"`{name}\((.*?)\)`", section)
        if found is None:
            continue
        named = [word.partition("=")[0].strip() for word in found[1].split(",")]
        function: Any = {"simulate": simulate, "Robot": Robot}.get(name) or getattr(Robot, name)
        known = [one for one in signature(function).parameters if one != "self"]
        assert named == known[: len(named)], name


def test_its_examples_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "out").mkdir()
    names: dict[str, Any] = {}
    try:
        for code in re.findall(r"^```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL):
            exec(compile(code, "docs/python.md", "exec"), names)
    finally:
        names["robot"].close()
    assert names["end"].succeeded
    assert all(one.succeeded for one in names["ends"])
    assert names["occupied"] > 100
    assert (tmp_path / "out" / "my_map.yaml").is_file()


def test_errors_are_said_as_on_the_page() -> None:
    said = PAGE.partition("```text\n")[2].partition("```")[0]
    with simulate(at=(3.5, 0.0, 0.0)) as robot:
        for call in (lambda: robot.forward(5.0), lambda: robot.turn(90)):
            with pytest.raises(Exception, match=r"clearance|degrees") as caught:
                call()
            assert str(caught.value) in said
