"""A planner and a node of behavior trees are each added by docs/extending.md alone."""

from __future__ import annotations

import inspect
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arjuna_core.config import load, plugin_names
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_nav import planners
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners import base, navfn
from arjuna_nav.planners.base import PLANNERS, PlanStatus
from tests.helpers.extending import ROOT, files_of

NODE = '''

class IsFast(Condition):
    """Succeeds where the robot is fast."""

    speed = Port(NUMBER, 0.3)

    def _holds(self) -> bool:
        return self.tree.state.velocity.x > self.speed
'''
TICKS = """
from arjuna_core.twist import Velocity
from arjuna_nav.trees.exchange import TreeState
from arjuna_nav.trees.xml_file import build_tree

tree = build_tree("<root><BehaviorTree><IsFast speed='0.5'/></BehaviorTree></root>", "own")
for speed in (0.4, 0.6):
    print(tree.tick(TreeState(0.0, velocity=Velocity(speed)))[0].name)
"""


def test_a_planner_is_two_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert files_of("A planner") == [Path(inspect.getfile(module)) for module in (navfn, base)]
    page = (ROOT / "docs" / "plugins.md").read_text(encoding="utf-8")
    code = re.findall(r"```python\n(.+?)```", page, re.DOTALL)[0]
    (tmp_path / "straight.py").write_text(code, encoding="utf-8")
    monkeypatch.setattr(planners, "__path__", [*planners.__path__, str(tmp_path)])
    monkeypatch.setitem(PLANNERS.types, "own::Straight", "arjuna_nav.planners.straight:Straight")

    @dataclass(frozen=True)
    class Config:
        planner_plugins: tuple[str, ...] = plugin_names(("Line",), "The planners.", PLANNERS)

    values = {"Line.plugin": "own::Straight", "Line.points": 5}
    config: Any = load(Config, values, "planner_server")
    planner = PLANNERS.make(config.Line, Footprint.circle(0.2))
    plan = planner.plan(None, IDENTITY, SE2(1.0, 2.0))
    assert plan.status is PlanStatus.SUCCEEDED
    np.testing.assert_allclose(plan.path[:, 1], [0.0, 0.5, 1.0, 1.5, 2.0])


def test_a_node_of_trees_is_one_file(tmp_path: Path) -> None:
    (file,) = files_of("A node of behavior trees")
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "arjuna_nav" / "trees", tmp_path / "arjuna_nav/trees", ignore=ignored)
    (tmp_path / "arjuna_nav/__init__.py").touch()
    with (tmp_path / file.relative_to(ROOT)).open("a", encoding="utf-8") as text:
        text.write(NODE)
    run = subprocess.run(
        [sys.executable, "-c", TICKS], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert run.stdout.split() == ["FAILURE", "SUCCESS"]
