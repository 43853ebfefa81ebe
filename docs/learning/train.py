"""Trains a policy that drives to goals in the room among boxes: `python train.py`."""

from __future__ import annotations

import argparse
import os
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")  # the matrices are small, and the cores the robots'

import gymnasium
import numpy as np
from learned_policy import Floats, Policy, forward

import arjuna  # noqa: F401  (makes the environment known)
from arjuna_core.pose3 import Pose3
from arjuna_sim.inputs import named_world
from arjuna_sim.learning.task import TaskConfig
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.model.world import Body, World

ID = "arjuna/Navigate-v0"
ROBOTS, STEPS, EPOCHS, BATCH = 16, 128, 8, 256
DISCOUNT, TRACE, CLIP, RATE, ENTROPY = 0.99, 0.95, 0.2, 5e-4, 0.002


def room(seed: list[int], boxes: int = 10) -> World:
    """Return the shipped room with more boxes, wherever they fall."""
    rng, bodies = np.random.default_rng(seed), []
    for i in range(boxes):
        x, y = rng.uniform(-4.5, 4.5, 2)
        size = (*rng.uniform(0.2, 0.8, 2), 0.6)
        pose = Pose3.from_rpy((x, y, 0.3), (0.0, 0.0, rng.uniform(0.0, np.pi)))
        bodies.append(Body(f"box_{i}", Part(Shape(Kind.BOX, size), pose), True))
    world = named_world("")
    return replace(world, bodies=(*world.bodies, *bodies))


def network(sizes: list[int], last: float, rng: np.random.Generator) -> list[Floats]:
    """Return layers of orthogonal weights, those of the last one scaled."""
    layers = []
    for rows, columns in pairwise(sizes):
        side = max(rows, columns)
        weights = np.linalg.qr(rng.standard_normal((side, side)))[0][:rows, :columns]
        layers += [weights.copy(), np.zeros(columns)]
    layers[-2] *= last
    return layers


def gradients(layers: list[Floats], outputs: list[Floats], slope: Floats) -> list[Floats]:
    """Return the gradient of each layer, given that of the last one's outputs."""
    found: list[Floats] = []
    for i in range(len(layers) - 2, -1, -2):
        inputs = outputs[i // 2]
        found = [inputs.T @ slope, slope.sum(axis=0), *found]
        slope = (slope @ layers[i].T) * (1.0 - inputs**2)
    return found


class Adam:
    """Moves values down their gradients, which are cut to a length of 0.5.

    Source: Kingma and Ba, Adam: a method for stochastic optimization, ICLR 2015.
    """

    def __init__(self, values: list[Floats]) -> None:
        self._values, self._count = values, 0
        self._means = [np.zeros_like(value) for value in values]
        self._squares = [np.zeros_like(value) for value in values]

    def step(self, found: list[Floats], rate: float) -> None:
        """Take one step."""
        self._count += 1
        length = np.sqrt(sum((each**2).sum() for each in found))
        rows = zip(self._values, self._means, self._squares, found, strict=True)
        for value, mean, square, each in rows:
            cut = each * min(1.0, 0.5 / (length + 1e-9))
            mean += 0.1 * (cut - mean)
            square += 0.001 * (cut**2 - square)
            deviation = np.sqrt(square / (1.0 - 0.999**self._count)) + 1e-5
            value -= rate * mean / (1.0 - 0.9**self._count) / deviation


class Trainer:
    """Trains a policy with a Gaussian around its actions, and a critic.

    Source: Schulman et al., Proximal policy optimization algorithms, 2017.
    """

    def __init__(self, envs: gymnasium.vector.VectorEnv, config: TaskConfig, seed: int) -> None:
        self._envs, self._rng = envs, np.random.default_rng(seed)
        low, high = envs.single_action_space.low, envs.single_action_space.high
        inputs = config.sectors + 3 + len(low)
        actor = network([inputs, 64, 64, len(low)], 0.01, self._rng)
        self.policy = Policy(actor, low, high, config)
        self._critic = network([inputs, 64, 64, 1], 1.0, self._rng)
        self.spread = np.full(len(low), -0.7)  # logarithm of the standard deviation
        self._adam = Adam([*actor, self.spread, *self._critic])
        self._seen, _ = envs.reset(seed=seed)
        self._ended = np.zeros(envs.num_envs, bool)  # so that the next step only begins anew
        self.successes: list[bool] = []

    def _value(self, features: Floats) -> Floats:
        return forward(self._critic, features)[-1][..., 0]

    def collect(self) -> list[Floats]:
        """Drive; return features, actions, their likelihoods, advantages and returns."""
        rows = []
        for _ in range(STEPS):
            features = self.policy.features(self._seen)
            mean = forward(self.policy.layers, features)[-1]
            noise = self._rng.standard_normal(mean.shape)
            action = mean + np.exp(self.spread) * noise
            likelihood = (-0.5 * noise**2 - self.spread).sum(axis=1)
            counts = ~self._ended
            self._seen, reward, terminated, truncated, info = self._envs.step(
                self.policy.scaled(action)
            )
            after = self._value(self.policy.features(self._seen)) * ~terminated
            value, self._ended = self._value(features), terminated | truncated
            self.successes += [bool(info["is_success"][i]) for i in np.flatnonzero(self._ended)]
            rows.append((features, action, likelihood, reward, value, after, self._ended, counts))
        columns = (np.array(column) for column in zip(*rows, strict=True))
        features, action, likelihood, reward, value, after, ended, counts = columns
        advantage, later = np.zeros_like(value), np.zeros(value.shape[1])
        for t in range(STEPS - 1, -1, -1):
            error = reward[t] + DISCOUNT * after[t] - value[t]
            later = error + DISCOUNT * TRACE * ~ended[t] * later
            advantage[t] = later
        batch = features, action, likelihood, advantage, advantage + value
        return [column[counts] for column in batch]

    def improve(self, batch: list[Floats], rate: float) -> None:
        """Take steps up the clipped objective, and down the critic's error."""
        for _ in range(EPOCHS):
            order = self._rng.permutation(len(batch[0]))
            for rows in np.array_split(order, max(1, len(order) // BATCH)):
                self._step(*(column[rows] for column in batch), rate)

    def _step(
        self,
        features: Floats,
        action: Floats,
        likelihood: Floats,
        advantage: Floats,
        target: Floats,
        rate: float,
    ) -> None:
        count, deviation = len(features), np.exp(self.spread)
        advantage = (advantage - advantage.mean()) / (advantage.std() + 1e-8)
        outputs = forward(self.policy.layers, features)
        noise = (action - outputs[-1]) / deviation
        ratio = np.exp((-0.5 * noise**2 - self.spread).sum(axis=1) - likelihood)
        clipped = np.where(advantage > 0.0, ratio > 1.0 + CLIP, ratio < 1.0 - CLIP)
        weight = (-advantage * ratio * ~clipped / count)[:, None]
        actor = gradients(self.policy.layers, outputs, weight * noise / deviation)
        spread = (weight * (noise**2 - 1.0)).sum(axis=0) - ENTROPY
        values = forward(self._critic, features)
        slope = 0.5 * (values[-1] - target[:, None]) / count
        self._adam.step([*actor, spread, *gradients(self._critic, values, slope)], rate)


def evaluate(policy: Policy, goals: int, seed: int = 1000, **task: Any) -> tuple[int, int]:
    """Drive to goals; return how many were reached, and in how many drives something was touched.

    Args:
        task: Arguments of the environment: by default the shipped room.
    """
    env, reached, touched = gymnasium.make(ID, **task), 0, 0
    for i in range(goals):
        seen, _ = env.reset(seed=seed + i)
        done = False
        while not done:
            action = policy.act({name: value[None] for name, value in seen.items()})[0]
            seen, _, terminated, truncated, info = env.step(action)
            done = terminated or truncated
        reached += info["is_success"]
        touched += info["touched"]
    return reached, touched


def main(argv: list[str] | None = None) -> None:
    """Train, save, and evaluate what was saved."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=400_000, help="of all robots (%(default)s)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", type=Path, default=Path(__file__).with_name("policy.npz"))
    parser.add_argument("--goals", type=int, default=100, help="to evaluate (%(default)s)")
    arguments = parser.parse_args(argv)
    worlds = [room([arguments.seed, i]) for i in range(ROBOTS)]
    envs = gymnasium.vector.AsyncVectorEnv(
        [lambda world=world: gymnasium.make(ID, world=world) for world in worlds]
    )
    trainer = Trainer(envs, TaskConfig(), arguments.seed)
    rounds, began = arguments.steps // (ROBOTS * STEPS), time.monotonic()
    for i in range(rounds):
        trainer.improve(trainer.collect(), RATE * (1.0 - i / rounds))
        if (i + 1) % 20 == 0 or i + 1 == rounds:
            trainer.policy.save(arguments.output)
            last = trainer.successes[-200:]
            print(
                f"{(i + 1) * ROBOTS * STEPS:8} steps {time.monotonic() - began:6.0f} s,"
                f" {sum(last)} of the last {len(last)} goals reached",
                flush=True,
            )
    envs.close()
    reached, touched = evaluate(Policy.load(arguments.output), arguments.goals)
    print(
        f"of {arguments.goals} goals in the shipped room {reached} reached, {touched} drives"
        " touched something"
    )


if __name__ == "__main__":
    main()
