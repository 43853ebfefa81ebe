"""Claims: what docs/learning.md shows trains, repeats itself, and drives the whole stack."""

from __future__ import annotations

import gc
import importlib
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from bringup.scenarios.drive import Drive, placed
from tests.helpers.robots import ROOM
from tests.sim.builders import ROOT

pytestmark = pytest.mark.ros
FOLDER = ROOT / "docs" / "learning"


@pytest.fixture(autouse=True)
def example(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(FOLDER)


def module(name: str) -> Any:
    return importlib.import_module(name)


@pytest.mark.system
def test_the_shipped_policy_drives_among_the_boxes() -> None:
    from bringup.client.goals import Goals
    from bringup.lockstep import LockStep
    from bringup.parameters.files import load_parameters, merged, shipped_parameters
    from bringup.parameters.foreign.understanding import understand
    from bringup.stack import LOCALIZATION_GROUP, NAVIGATION_GROUP, SIM_GROUP, all_nodes

    learned = load_parameters([FOLDER / "learned.yaml"])
    values = understand(learned, shipped_parameters(), all_nodes()).parameters
    values = merged(merged(values, ROOM), placed(SE2(1.0, 0.0, 3.0)))
    with closing(LockStep(values)) as robot:
        robot.start(SIM_GROUP, LOCALIZATION_GROUP, NAVIGATION_GROUP)
        robot.run(1.0)
        drive, goals = Drive(robot), Goals(robot)
        for goal in (SE2(4.0, 0.0, 0.0), SE2(-2.0, -4.0, 1.0)):
            assert goals.navigate(goal, 90.0).succeeded
            assert drive.truth.distance(goal) < 0.1
        assert drive.touches == 0


def test_the_shipped_policy_reaches_goals_by_itself() -> None:
    pytest.importorskip("gymnasium", reason="the extra 'learn' is not installed")
    policy = module("learned_policy").Policy.load(FOLDER / "policy.npz")
    reached, touched = module("train").evaluate(policy, 10, seed=5000)
    assert (reached, touched) == (10, 0)


def test_training_is_deterministic(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("gymnasium", reason="the extra 'learn' is not installed")
    train = module("train")
    monkeypatch.setattr(train, "ROBOTS", 2)
    monkeypatch.setattr(train, "STEPS", 16)
    written = []
    gc.collect()
    gc.freeze()  # its processes are forked: what other tests left of ROS is not theirs to free
    for seed, name in ((3, "a"), (3, "b"), (4, "c")):
        output = tmp_path / f"{name}.npz"
        options = ["--steps", "64", "--seed", f"{seed}", "--goals", "0"]
        train.main([*options, "--output", str(output)])
        written.append(output.read_bytes())
    assert written[0] == written[1] != written[2]


def test_gradients_are_those_of_finite_differences() -> None:
    pytest.importorskip("gymnasium", reason="the extra 'learn' is not installed")
    train, rng = module("train"), np.random.default_rng(0)
    forward = module("learned_policy").forward
    layers = train.network([3, 4, 4, 2], 1.0, rng)
    inputs, slope = rng.standard_normal((5, 3)), rng.standard_normal((5, 2))
    found = train.gradients(layers, forward(layers, inputs), slope)
    for layer, gradient in zip(layers, found, strict=True):
        expected = np.zeros_like(layer)
        for at in np.ndindex(layer.shape):
            ends = []
            for step in (1e-6, -2e-6):
                layer[at] += step
                ends.append((forward(layers, inputs)[-1] * slope).sum())
            layer[at] += 1e-6
            expected[at] = (ends[0] - ends[1]) / 2e-6
        np.testing.assert_allclose(gradient, expected, atol=1e-7)
