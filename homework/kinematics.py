"""Judges of `kinematics`: both formulas are right, for both are the course's."""

import math
from typing import Any

import numpy as np

from bringup.homework.exercise import Mark


def straight(attempt: Any) -> Mark:
    """Judge a drive ahead."""
    return _near(attempt, (1.0, -2.0, 0.6), [(0.5, 0.5)])


def on_the_spot(attempt: Any) -> Mark:
    """Judge a turn."""
    return _near(attempt, (1.0, -2.0, 0.6), [(-0.1, 0.1)])


def one_step(attempt: Any) -> Mark:
    """Judge small steps from poses that are drawn."""
    rng = np.random.default_rng(attempt.exercise.seed)
    poses, wheels = rng.uniform(-3.0, 3.0, (5, 3)), rng.uniform(-0.01, 0.02, (5, 2))
    marks = [_near(attempt, tuple(p), [tuple(w)]) for p, w in zip(poses, wheels, strict=True)]
    return min(marks, key=lambda mark: mark.share)


def many_steps(attempt: Any) -> Mark:
    """Judge a path."""
    rng = np.random.default_rng(attempt.exercise.seed + 1)
    return _near(attempt, (0.0, 0.0, 0.0), [tuple(w) for w in rng.uniform(0.0, 0.02, (100, 2))])


def _near(attempt: Any, start: tuple[float, ...], wheels: list[tuple[float, ...]]) -> Mark:
    """Compare the end of a path with both formulas' [m, m, rad]."""
    baseline, pose = 0.16, list(map(float, start))
    for left, right in wheels:
        pose = attempt.numbers("moved", 3, pose, left, right, baseline)
    ends = [np.array(start, float), np.array(start, float)]
    for left, right in wheels:
        path, turn = (left + right) / 2.0, (right - left) / baseline
        for end, bend in zip(ends, (0.0, turn), strict=True):
            chord, heading = path * np.sinc(bend / 2.0 / math.pi), end[2] + bend / 2.0
            end += (chord * math.cos(heading), chord * math.sin(heading), turn)
    off = min(float(np.abs(_wrapped(end - pose)).max()) for end in ends)
    got = ", ".join(f"{value:.3f}" for value in pose)
    return Mark(float(off < 1e-6), f"moved(...) ended at ({got}), {off:.3f} off")


def _wrapped(off: Any) -> Any:
    return np.array([off[0], off[1], math.remainder(off[2], 2.0 * math.pi)])
