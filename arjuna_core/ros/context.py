"""Contexts of rclpy, the middleware set up as a robot with a camera needs it."""

from __future__ import annotations

import contextlib
import gc
import importlib
import os
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import rclpy
from rclpy.context import Context

from arjuna_core.errors import ArjunaError
from arjuna_core.ros.shared_memory import remove_leftovers

_PROFILES = "FASTRTPS_DEFAULT_PROFILES_FILE"
_OURS = {
    False: Path(__file__).with_name("fastdds.xml"),
    True: Path(__file__).with_name("fastdds_open.xml"),
}
"""The profiles, by whether other hosts are reached."""
_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
_FOR_ROS = "--ros-args"
_COLLECT = (100_000, 20, 20)
"""How many new objects, and collections of those, are waited for before a collection of garbage.

Python's own (700, 10, 10) looks through all of a stack's 300 000 objects every 20 s of a run, which
holds its nodes up for 0.15 s each time; messages are freed without it."""
_GENERATOR = "rosidl_generator_py.generate_py_impl"


@contextlib.contextmanager
def discovery(isolated: bool) -> Iterator[None]:
    """Set the discovery range for the contexts made within."""
    before = os.environ.get(_RANGE)
    os.environ[_RANGE] = "OFF" if isolated else before or "LOCALHOST"
    try:
        yield
    finally:
        if before is None:
            del os.environ[_RANGE]
        else:
            os.environ[_RANGE] = before


def new_context(domain_id: int | None = None, words: list[str] | None = None) -> Context:
    """Return an initialized context; what the environment says of the middleware comes first.

    Without it, the interfaces of this Python environment are found, discovery and sockets are on
    this machine only, and Fast DDS has shared memory enough for pictures. A range that reaches
    other hosts, or static peers, open the sockets. Garbage is collected less often, and
    what killed processes left in shared memory is removed.

    Args:
        domain_id: The domain; the environment's if None.
        words: Those that ROS reads its arguments from; the program's behind `--ros-args` if None:
            its own `NAME:=VALUE` are no remappings.

    Raises:
        ArjunaError: ROS cannot read them.
    """
    add_environment_to_ament_index()
    gc.set_threshold(*_COLLECT)
    # messages' package takes its generator along if it can: parsers, a quarter of a node's start
    sys.modules.setdefault(_GENERATOR, None)  # type: ignore[arg-type]
    os.environ.setdefault(_RANGE, "LOCALHOST")
    if os.environ.get(_PROFILES, "") in ("", *map(str, _OURS.values())):  # a parent's may differ
        os.environ[_PROFILES] = str(_OURS[reaches_other_hosts(os.environ)])
    remove_leftovers()
    context = Context()
    if words is None:
        words = sys.argv[sys.argv.index(_FOR_ROS) :] if _FOR_ROS in sys.argv else []
    try:
        rclpy.init(args=words, context=context, domain_id=domain_id)
    except RuntimeError as error:  # rcl's, of words that it cannot read
        raise ArjunaError(str(error)) from error
    return context


def reaches_other_hosts(environment: Mapping[str, str]) -> bool:
    """Return whether the middleware is to reach other hosts, by an environment's variables."""
    peers = environment.get("ROS_STATIC_PEERS", "").strip("; ")
    return bool(peers) or environment.get(_RANGE, "LOCALHOST") not in ("LOCALHOST", "OFF")


_VARIABLE = "AMENT_PREFIX_PATH"


def add_environment_to_ament_index() -> None:
    """Append this Python environment to the ament index, behind a sourced ROS's prefixes."""
    prefixes = [entry for entry in os.environ.get(_VARIABLE, "").split(os.pathsep) if entry]
    if sys.prefix not in prefixes:
        os.environ[_VARIABLE] = os.pathsep.join([*prefixes, sys.prefix])


def class_of(name: str) -> Any:
    """Return the class of an interface, `package/kind/Name`.

    Names of an action's feedback messages and of a service's events are known too.

    Raises:
        LookupError: No installed package has it.
    """
    package, _, rest = name.partition("/")
    kind, _, short = rest.partition("/")
    if not all(part.isidentifier() for part in (package, kind, short)):
        raise LookupError(f"'{name}' is no type; valid: package/msg/Name")
    try:
        module = importlib.import_module(f"{package}.{kind}")
        if kind == "action" and short.endswith("_FeedbackMessage"):
            return getattr(module, short.removesuffix("_FeedbackMessage")).Impl.FeedbackMessage
        if kind == "srv" and short.endswith("_Event"):
            return getattr(module, short.removesuffix("_Event")).Event
        return getattr(module, short)
    except (ImportError, AttributeError) as error:
        raise LookupError(f"type '{name}' is not installed") from error


def full_names(node: Any) -> list[str]:
    """Return the full names of the nodes that a node sees, a name that occurs twice twice."""
    return [full_name(*pair) for pair in node.get_node_names_and_namespaces()]


def full_name(name: str, namespace: str) -> str:
    """Return a node's full name."""
    return f"{namespace.rstrip('/')}/{name}"
