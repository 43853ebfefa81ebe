"""CPU time of a lock-step run by part of the code and by node, sampled by a timer's signal."""

from __future__ import annotations

import re
import signal
import time
from collections import defaultdict
from functools import cache
from types import FrameType
from typing import Any

from arjuna_core.ros.node import ManagedNode

PARTS = (
    ("recorder", r"bringup\.recording|arjuna_core\.(bags|ros\.local\.cdr)"),
    ("transforms", r"arjuna_core\.(transforms|se2|pose3|ros\.tf)"),
    ("logging", r"rclpy\.impl\.rcutils_logger"),
    ("plumbing", r"arjuna_core\.(ros|checks)|rclpy|\w+\.(msg|srv|action)\."),
    ("costmaps", r"arjuna_nav\.(nodes\.)?costmap"),
    ("controllers", r"arjuna_nav\.controllers"),
    ("planners", r"arjuna_nav\.(planners|smoothers|exploration)"),
    ("navigator", r"arjuna_nav\.(trees|nodes\.bt_navigator)"),
    ("nodes", r"arjuna_\w+\.nodes"),
    ("physics and sensors", r"arjuna_sim|mujoco"),
    ("SLAM and AMCL", r"arjuna_slam"),
)
"""The parts of a step and their modules, the first that matches.

Message plumbing is what a robot in one class would not have: processes, nodes, transport,
conversion, checks (`arjuna_core.ros`), rclpy, and messages' constructors;
not the arithmetic of transforms, which one class needs too, nor logging, nor what is recorded.
"""
_PERIOD = 0.004  # of the process's CPU time, so that a sample's 30 us stay below 1 % [s]


class Samples:
    """A context in which the CPU time of `LockStep.step` is sampled.

    A sample belongs to the innermost frame that is in one of the parts, except that the recorder
    has all it calls; and to the node whose method or subscription is innermost.

    Attributes:
        parts: CPU time by part [s].
        nodes: CPU time by node [s].
        functions: CPU time by function, with its part [s].
    """

    def __init__(self) -> None:
        self.parts: defaultdict[str, float] = defaultdict(float)
        self.nodes: defaultdict[str, float] = defaultdict(float)
        self.functions: defaultdict[str, float] = defaultdict(float)
        self._last = 0.0

    def __enter__(self) -> Samples:
        self._last = time.process_time()
        signal.signal(signal.SIGPROF, self._sample)
        signal.setitimer(signal.ITIMER_PROF, _PERIOD, _PERIOD)
        return self

    def __exit__(self, *error: object) -> None:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, signal.SIG_DFL)

    def _sample(self, number: int, frame: FrameType | None) -> None:
        now = time.process_time()
        spent, self._last = now - self._last, now
        parts, node, function, stepping = [], None, "", False
        while frame is not None:
            module = frame.f_globals.get("__name__", "")
            part = _part(module)
            parts.append(part)
            function = function or (part and f"{part}: {module}.{frame.f_code.co_name}")
            node = node or _node(frame.f_locals.get("self"))
            stepping = stepping or (module == "bringup.lockstep" and frame.f_code.co_name == "step")
            frame = frame.f_back
        if stepping:
            found = "recorder" if "recorder" in parts else next(filter(None, parts), "other")
            self.parts[found] += spent
            self.nodes[node.get_name() if node else "the process"] += spent
            self.functions[function] += spent


@cache
def _part(module: str) -> str:
    return next((name for name, modules in PARTS if re.match(modules, module)), "")


def _node(owner: Any) -> ManagedNode | None:
    if type(owner).__module__.startswith("arjuna_"):  # others' attributes may be made when read
        owner = getattr(owner, "node", owner)
    return owner if isinstance(owner, ManagedNode) else None
