"""Pace of the learning environment: alone, and in processes side by side."""

from __future__ import annotations

import argparse
import time
from typing import Any

import gymnasium
import mujoco
import numpy as np

import arjuna  # noqa: F401  (makes the environment known)

_ID = "arjuna/Navigate-v0"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument("--steps", type=int, default=5000, help="a measurement (%(default)s)")
    parser.add_argument("--robots", type=int, default=2, help="side by side (%(default)s)")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Drive random actions in the shipped room, episodes and all, the best of three.

    Returns:
        By length of a step, 0.1 s and one tick: `per_cpu_second` of one environment,
        `mujoco_per_cpu_second` of its physics alone, and `per_second` of all `robots` by the clock.
    """
    found = {}
    for step in (0.1, 0.02):
        alone = max(_alone(step, arguments.steps) for _ in range(3))
        physics = max(_physics(step, arguments.steps) for _ in range(3))
        together = max(_together(step, arguments) for _ in range(3))
        print(
            f"steps of {step:g} s: {alone:7.0f} per CPU second (mj_step alone {physics:.0f});"
            f" {arguments.robots} robots side by side {together:7.0f} a second"
        )
        found[f"{step:g} s"] = {
            "per_cpu_second": alone,
            "mujoco_per_cpu_second": physics,
            "per_second": together,
        }
    return found


def _alone(step: float, count: int) -> float:
    env = gymnasium.make(_ID, step=step).unwrapped
    env.reset(seed=0)
    env.action_space.seed(0)
    actions = [env.action_space.sample() for _ in range(count)]
    began = time.process_time()
    for action in actions:
        _, _, terminated, truncated, _ = env.step(action)
        if terminated or truncated:
            env.reset()
    return count / (time.process_time() - began)


def _physics(step: float, count: int) -> float:
    env: Any = gymnasium.make(_ID, step=step).unwrapped
    env.reset(seed=0)
    for _ in range(10):
        env.step(np.array([0.4, 0.5], np.float32))
    stage = env.simulation.stage
    nstep = round(step / stage.scene.model.opt.timestep)
    began = time.process_time()
    for _ in range(count):
        mujoco.mj_step(stage.scene.model, stage.data, nstep=nstep)
    return count / (time.process_time() - began)


def _together(step: float, arguments: argparse.Namespace) -> float:
    envs = gymnasium.make_vec(_ID, arguments.robots, "async", step=step)
    envs.reset(seed=0)
    envs.action_space.seed(0)
    actions = [envs.action_space.sample() for _ in range(arguments.steps)]
    began = time.monotonic()
    for action in actions:
        envs.step(action)
    elapsed = time.monotonic() - began
    envs.close()
    return float(arguments.steps * arguments.robots / elapsed)
