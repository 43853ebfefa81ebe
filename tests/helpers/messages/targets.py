"""What can be sent to the nodes of a graph: topics that somebody hears, services, actions."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Any

import numpy as np
from rclpy.qos import DurabilityPolicy, QoSProfile

from tests.helpers.messages.fill import Filler

_ACTION_PARTS = {
    "_SendGoal": "SendGoalService",
    "_GetResult": "GetResultService",
    "_FeedbackMessage": "FeedbackMessage",
}
_REFUSED_TRANSITIONS = (0, 1, 2, 9, 10, 42, 60, 99, 255)  # of an active node
_NOT_TO_ASK = ("unload_world",)  # what a client may ask, and then nothing drives


@dataclass(frozen=True)
class Target:
    """Something to send to.

    Attributes:
        name: The topic or service.
        kind: `topic` or `service`; an action is three services.
        cls: The message class, or the service's.
    """

    name: str
    kind: str
    cls: Any


def found(node: Any) -> list[Target]:
    """Return all that others in a node's graph hear or serve, sorted by name."""
    own = {publisher.topic_name for publisher in node.publishers}
    topics = [
        Target(name, "topic", _class(types[0]))
        for name, types in node.get_topic_names_and_types()
        if node.count_subscribers(name) and name not in own
    ]
    services = [
        Target(name, "service", _class(types[0]))
        for name, types in node.get_service_names_and_types()
        if not name.endswith(_NOT_TO_ASK) and f"/{node.get_name()}/" not in name
    ]
    return sorted(topics + services, key=lambda target: target.name)


def drawn(targets: list[Target], rng: np.random.Generator) -> Target:
    """Return one of them; every type is as likely, however many nodes have a service of it."""
    kinds = sorted({str(target.cls) for target in targets if target.kind == "service"})
    kind = str(rng.choice(kinds))
    topics = rng.random() < 0.5
    some = [t for t in targets if (t.kind == "topic" if topics else str(t.cls) == kind)]
    return some[int(rng.integers(0, len(some)))]


def _class(name: str) -> Any:
    package, kind, short = name.split("/")
    module = importlib.import_module(f"{package}.{kind}")
    for suffix, part in _ACTION_PARTS.items():
        if kind == "action" and short.endswith(suffix):
            return getattr(getattr(module, short.removesuffix(suffix)).Impl, part)
    return getattr(module, short)


def profile(node: Any, topic: str) -> QoSProfile:
    """Return a profile that every subscription of a topic hears."""
    ends = node.get_subscriptions_info_by_topic(topic)
    latched = any(e.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for e in ends)
    durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
    return QoSProfile(depth=10, durability=durability)


def harmless(request: Any, rng: np.random.Generator) -> Any:
    """Return a request without what a client may rightly ask for and nothing drives after."""
    package, name = type(request).__module__.split(".")[0], type(request).__name__
    if name == "ChangeState_Request":
        request.transition.id = int(rng.choice(_REFUSED_TRANSITIONS))
        request.transition.label = str(rng.choice(("", "", "", "x")))
    if name == "ManageLifecycleNodes_Request":
        request.command = max(request.command, 7)
    if name == "SetSimulationState_Request" and request.state.state == 3:
        request.state.state = 2
    if name == "TFMessage" and package == "tf2_msgs":
        for item in request.transforms[:100]:
            item.child_frame_id = f"foreign_{item.child_frame_id[:20]}"
    return request


def filled(target: Target, filler: Filler, rng: np.random.Generator, names: list[str]) -> Any:
    """Return a message or request for a target; parameters are often those that are there."""
    cls = target.cls if target.kind == "topic" else target.cls.Request
    made = harmless(filler.message(cls), rng)
    for item in getattr(made, "parameters", [])[:100]:
        if hasattr(item, "value") and names and rng.random() < 0.9:
            item.name = str(rng.choice(names))
            item.value.type = int(rng.choice((1, 2, 3, 4, 3, 3)))
    return made
