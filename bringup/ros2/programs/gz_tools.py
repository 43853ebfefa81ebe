"""`gz topic`, `gz service` and `gz model`, as tutorials write them, by commands that are here.

Their messages are in the text format of protocol buffers: `name: "box", position: {x: 1.5}`.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import re
from collections.abc import Iterator, Mapping
from typing import Any

from arjuna_sim.model.settings import spelled
from bringup.ros2.errors import Ros2Error

_TOKEN = re.compile(
    r"""\s*(?:(?P<text>"(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*')|(?P<word>[^\s,;:{}<>"']+)|(?P<sign>.))""",
    re.DOTALL,
)
_TYPES = {
    "Twist": "geometry_msgs/msg/Twist",
    "Boolean": "std_msgs/msg/Bool",
    "Double": "std_msgs/msg/Float64",
    "Empty": "std_msgs/msg/Empty",
    "Float": "std_msgs/msg/Float32",
    "Int32": "std_msgs/msg/Int32",
    "StringMsg": "std_msgs/msg/String",
}
_SERVICES = ("create", "remove", "set_pose", "control")
_PLACES = ("x", "y", "z")


def read_message(text: str) -> dict[str, Any]:
    """Return the fields of a message in the text format.

    Raises:
        Ros2Error: It is not in that format.
    """
    tokens = [(m["text"], m["word"], m["sign"]) for m in _TOKEN.finditer(text.strip())]
    stream = iter([token for token in tokens if token[2] not in (",", ";", ":")])
    return dict(_fields(stream, nested=False))


def _fields(stream: Iterator[Any], nested: bool) -> Iterator[tuple[str, Any]]:
    for _, name, sign in stream:
        if nested and sign in ("}", ">"):
            return
        if name is None:
            raise Ros2Error("a message has fields as 'name: \"box\", position: {x: 1.5}'")
        text, word, sign = next(stream, (None, None, None))
        if sign in ("{", "<"):
            yield name, dict(_fields(stream, nested=True))
        elif text is not None:
            yield name, text[1:-1]
        elif word is not None:
            yield name, _value(word)
        else:
            raise Ros2Error(f"a message's field '{name}' has no value")
    if nested:
        raise Ros2Error("a message lacks a closing brace")


def _value(word: str) -> bool | float | str:
    if word in ("true", "false"):
        return word == "true"
    for kind in (int, float):
        with contextlib.suppress(ValueError):
            return kind(word)
    return word


def command_of(words: list[str]) -> tuple[str, list[str]]:
    """Return the program here, and its words, that do what a call of `gz` asks for.

    Args:
        words: Such as `topic -t /cmd_vel -m gz.msgs.Twist -p 'linear: {x: 0.5}'`.

    Returns:
        `ros2`, `create` (which spawns), or a command of `arjuna`; and its words.

    Raises:
        Ros2Error: There is none; the message names what there is.
    """
    parser = argparse.ArgumentParser(prog=f"gz {words[0]}", add_help=False)
    for flag, name in (("-t", "topic"), ("-m", "msgtype"), ("-p", "pub"), ("-s", "service")):
        parser.add_argument(flag, f"--{name}", default="")
    parser.add_argument("-n", "--num", default="")
    parser.add_argument("--req", default="")
    for flag, name in (("-l", "list"), ("-e", "echo"), ("-i", "info")):
        parser.add_argument(flag, f"--{name}", action="store_true")
    asked, _ = parser.parse_known_args(words[1:])
    if words[0] == "topic":
        return "ros2", _of_topic(asked)
    if words[0] == "service" and asked.list:
        return "ros2", ["service", "list"]
    if words[0] == "service":
        name = asked.service.rpartition("/")[2]
        try:
            return _of_service(name, read_message(asked.req))
        except (AssertionError, AttributeError, TypeError, ValueError) as error:
            raise Ros2Error(f"the request is none of '{name}': {asked.req}") from error
    if words[0] == "model":
        return "entity", ["list"]
    instead = "'ros2 topic', 'ros2 service' and 'arjuna entity' see and change the world"
    raise Ros2Error(f"'gz {words[0]}' asks Gazebo itself, which is not here; {instead}")


def _of_topic(asked: argparse.Namespace) -> list[str]:
    topic = spelled(asked.topic or "")
    if asked.list:
        return ["topic", "list"]
    if asked.info:
        return ["topic", "info", topic]
    if not asked.pub and not asked.msgtype:
        return ["topic", "echo", topic, *(["--once"] if asked.num == "1" else [])]
    kind = asked.msgtype.rpartition(".")[2]
    if kind not in _TYPES:
        raise Ros2Error(
            f"'gz topic' publishes no '{asked.msgtype}' here; valid: {', '.join(_TYPES)}"
        )
    message = json.dumps(read_message(asked.pub))
    return ["topic", "pub", "--once", topic, _TYPES[kind], message]


def _of_service(name: str, request: Mapping[str, Any]) -> tuple[str, list[str]]:
    pose = request.get("pose", request)
    x, y, z = (f"{float(pose.get('position', {}).get(key, 0.0)):g}" for key in _PLACES)
    heading = f"{_heading(pose.get('orientation', {})):g}"
    if name == "create":
        given = {"-name": "name", "-file": "sdf_filename", "-string": "sdf"}
        named = [word for o, key in given.items() if key in request for word in (o, request[key])]
        return "create", [*named, "-x", x, "-y", y, "-z", z, "-Y", heading]
    if name == "remove":
        return "entity", ["delete", str(request.get("name", ""))]
    if name == "set_pose":
        words = [str(request.get("name", "")), x, y, "--z", z, "--heading", heading]
        return "entity", ["move", *words]
    if name == "control" and "pause" in request:
        return "world", ["pause" if request["pause"] else "play"]
    if name == "control" and "multi_step" in request:
        return "world", ["step", f"{request['multi_step']:g}"]
    if name == "control" and "reset" in request:
        return "world", ["reset"]
    raise Ros2Error(f"no service '{name}' of Gazebo's is here; valid: {', '.join(_SERVICES)}")


def _heading(orientation: Mapping[str, float]) -> float:
    from geometry_msgs.msg import Quaternion

    from arjuna_core.ros.convert import yaw

    return float(yaw(Quaternion(**{"w": 1.0 if not orientation else 0.0, **orientation})))
