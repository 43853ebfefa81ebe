"""A policy: two hidden layers from observations to actions, which need NumPy alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from arjuna_sim.learning.task import TaskConfig

Floats = NDArray[np.float64]
Observed = dict[str, NDArray[np.float32]]
_TASK = ("sectors", "scan_reach", "goal_reach", "step")


class Policy:
    """Layers, and what they were trained on.

    Args:
        layers: Weights and biases by turns, from the first layer to the last.
        low: Least values of an action.
        high: Greatest values of an action.
        config: The task.
    """

    def __init__(
        self,
        layers: list[Floats],
        low: NDArray[np.float32],
        high: NDArray[np.float32],
        config: TaskConfig,
    ) -> None:
        self.layers, self.low, self.high, self.config = layers, low, high, config

    @staticmethod
    def load(path: Path) -> Policy:
        """Read what `save` has written."""
        with np.load(path, allow_pickle=False) as file:
            count = sum("layer" in name for name in file)
            layers = [file[f"layer{i}"].astype(np.float64) for i in range(count)]
            config = TaskConfig(**{name: file[name].item() for name in _TASK})
            return Policy(layers, file["low"], file["high"], config)

    def save(self, path: Path) -> None:
        """Write layers (`float32`), bounds, and what of the task an observation depends on."""
        task = {name: np.array(getattr(self.config, name)) for name in _TASK}
        layers = {f"layer{i}": layer.astype(np.float32) for i, layer in enumerate(self.layers)}
        np.savez_compressed(path, low=self.low, high=self.high, **layers, **task)

    def features(self, seen: Observed) -> Floats:
        """Return what the first layer takes, `(N, F)`: nearness, the goal in polar form, speeds."""
        x, y = seen["goal"].T
        distance = np.maximum(np.hypot(x, y), 1e-6)
        goal = np.column_stack((distance / self.config.goal_reach, x / distance, y / distance))
        return np.hstack((1.0 - seen["scan"], goal, seen["velocity"] / self.high))

    def scaled(self, output: Floats) -> NDArray[np.float32]:
        """Return the actions of the last layer's outputs, of which -1 to 1 are the bounds."""
        ratio = (np.clip(output, -1.0, 1.0) + 1.0) / 2.0
        return (self.low + ratio * (self.high - self.low)).astype(np.float32)

    def act(self, seen: Observed) -> NDArray[np.float32]:
        """Return the actions for observations, `(N, A)`."""
        return self.scaled(forward(self.layers, self.features(seen))[-1])


def forward(layers: list[Floats], inputs: Floats) -> list[Floats]:
    """Return the outputs of all layers, the inputs first."""
    outputs = [inputs]
    for i in range(0, len(layers), 2):
        value = outputs[-1] @ layers[i] + layers[i + 1]
        outputs.append(value if i + 2 == len(layers) else np.tanh(value))
    return outputs
