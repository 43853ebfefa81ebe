"""Gazebo's programs, as the simulator: a world that waits for its robot, and what spawns it."""

from __future__ import annotations

import argparse
import math
import os
import re
import time
from collections.abc import Collection
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

from rclpy.qos import QoSProfile
from simulation_interfaces.msg import Resource, Result
from simulation_interfaces.srv import SpawnEntity
from std_msgs.msg import String

from arjuna_core.errors import ArjunaError
from arjuna_core.files.input_file import read_text
from arjuna_core.files.whole_file import own_folder
from arjuna_core.ros import qos
from arjuna_core.ros.convert import quaternion, yaw
from arjuna_sim.files.world_file import robots_in
from arjuna_sim.inputs import named_robot
from bringup.client.simulator import SimulatorClient, SimulatorError, resource_of
from bringup.ros2.client import Client
from bringup.ros2.errors import Ros2Error
from bringup.ros2.programs.gz_tools import command_of
from bringup.ros2.verbs.forward import LAUNCHED, arjuna, nothing, ros_arguments
from bringup.ros2.worlds import ENDINGS, world_of

_PATIENCE_UNTOLD = 2.0  # [s] for a world's file, before it is said to lack
_PATIENCE = 60.0  # [s] for a description, and for a world that takes it
_PUBLISHER_STARTS = 8.0  # [s] from the start of a launch file
_MOVING = re.compile(r"type=['\"](continuous|revolute)|xacro:")
_WINDOW = "'arjuna view' shows the world"
_TOOLS = ("fuel", "gui", "log", "model", "msg", "param", "plugin", "sdf", "service", "topic")


def serve(words: list[str]) -> None:
    """Simulate what is spawned, or the robots that the world has, in the world that words name."""
    if words[:1] == ["service"] and any(word.startswith("/gui/") for word in words):
        print(f"nothing to do: {_WINDOW}", flush=True)
        return
    if "-g" in words and "-s" not in words:
        nothing(words, _WINDOW)
        return
    if words[:1] and words[0] in _TOOLS:
        _as_tool(words)
        return
    wanted: list[list[str]] = []
    with Client(name="gazebo") as client:
        name = named_world(words)
        if name.startswith("/"):  # a launch file's xacro may write it just now
            for patience in (_PATIENCE_UNTOLD, _PATIENCE):
                if client.run_until(Path(name).is_file, patience, required=False):
                    break
                print(f"waits for the world: there is no {name}", flush=True)
        world = world_of(name)
        held = robots_in(world)
        folder = own_folder("robot")  # as long as the simulator that this process becomes
        spawn = partial(_spawn, wanted, client, folder.name, held)
        for service in ("/spawn_entity", "/gzserver/spawn_entity"):
            client.node.create_service(SpawnEntity, service, spawn)
        if not held:
            spawns = "'ros2 run ros_gz_sim create' spawns one"
            print(f"{world.name} waits for a robot: {spawns}", flush=True)
        patience = _PUBLISHER_STARTS if LAUNCHED in os.environ else 0.0
        client.run_until(lambda: bool(wanted), patience if held else math.inf, required=False)
        if not wanted:
            wanted.append(_of_world(client))
        client.pause(0.5)  # [s] in which the answer arrives
    arjuna("sim", ["--world", str(world), *wanted[0]])


def _spawn(
    wanted: list[list[str]],
    client: Client,
    folder: str,
    held: Collection[str],
    request: Any,
    response: Any,
) -> Any:
    """Note how the simulator has to start for a robot, the first one that drives.

    One whose name a robot of the world has is that robot, as Gazebo makes no second one of a name.
    """
    resource = request.entity_resource
    response.entity_name = request.name
    problem = "it starts"  # who asks too early asks again, and overwrites no robot of another
    if request.name in held:
        print(f"'{request.name}' stands in the world's file: that one drives", flush=True)
        wanted.append(_of_world(client))
        response.result.result = Result.RESULT_OK
        return response
    if not wanted:
        path = Path(resource.uri or _written(resource.resource_string, folder))
        problem = unfit(path)
    if problem:
        response.result.result = Result.RESULT_INCORRECT_STATE
        response.result.error_message = f"the world waits for a robot that drives: {problem}"
        return response
    pose = request.initial_pose.pose
    x, y, heading = pose.position.x, pose.position.y, yaw(pose.orientation)
    options = ["--robot", str(path), "--at", f"{x}", f"{y}", "--yaw", f"{heading}"]
    space = request.entity_namespace.strip("/")
    described = client.node.count_publishers(f"/{space}/robot_description".replace("//", "/"))
    own = ["--without-description"] if described or space else []
    if space and not described:  # its own robot_state_publisher, below the namespace
        own += ["--param", "sim:frames_of_file:=false"]
    wanted.append([*options, *(["--namespace", space] if space else []), *own])
    response.result.result = Result.RESULT_OK
    return response


def _of_world(client: Client) -> list[str]:
    """Return the simulator's options for the robots of the world's file."""
    described = client.node.count_publishers("/robot_description")
    return ["--without-description"] if described else []


def _as_tool(words: list[str]) -> None:
    """Do what `gz topic`, `gz service` or `gz model` does."""
    program, own = command_of(words)
    if program == "create":
        create(own)
    elif program == "ros2":
        from bringup.ros2.main import main  # which knows all programs, this one too

        raise SystemExit(main(own))
    else:
        arjuna(program, own)


def named_world(words: list[str]) -> str:
    """Return the world among Gazebo's words; `-s` takes a value in Gazebo classic alone."""
    named = (word for word in ros_arguments(words).own if word.endswith(ENDINGS))
    return next(named, "empty.world")


def unfit(path: Path) -> str:
    """Return why a file is no robot that drives; nothing where it is one."""
    try:
        named_robot(str(path), "")
        text = read_text(path, 20_000_000)
    except ArjunaError as error:
        return str(error)
    return "" if _MOVING.search(text) else f"{path.name} has no joint that turns"


def create(words: list[str]) -> None:
    """Spawn a robot or a model, as `ros_gz_sim create` and `gazebo_ros spawn_entity.py` do."""
    given, parser = ros_arguments(words), argparse.ArgumentParser(prog="create", add_help=False)
    for names in (("topic",), ("file",), ("string",), ("database",), ("name", "entity", "model")):
        parser.add_argument(*(f"-{one}" for one in names), *(f"--{one}" for one in names))
    parser.add_argument("-robot_namespace", "--robot_namespace", "-namespace", default="")
    for name in ("x", "y", "z", "R", "P", "Y"):
        parser.add_argument(f"-{name}", f"--{name}", type=float, default=0.0)
    chosen, _ = parser.parse_known_args(given.own)
    for name, value in given.values.items():
        if hasattr(chosen, name):
            setattr(chosen, name, float(value) if len(name) == 1 else value)
    with closing(SimulatorClient(_PATIENCE, given.remapped.get("__ns", ""))) as client:
        if chosen.topic:
            resource = Resource(resource_string=_received(client, chosen.topic))
        elif named := chosen.file or chosen.database:
            resource = resource_of(str(named).removeprefix("file://"))
        elif chosen.string:
            resource = Resource(resource_string=chosen.string)
        else:
            raise Ros2Error("nothing to spawn; valid: -topic T, -file F, -string TEXT")
        own, text = given.remapped.get("__ns", ""), resource.resource_string
        space = chosen.robot_namespace.strip("/") or space_of(own, chosen.topic or "", text)
        if LAUNCHED in os.environ:
            if not space and f">/{chosen.name}/" in _text_of(resource):  # its file's topics
                is_there = await_description(client, f"/{chosen.name}/robot_")
                space = chosen.name if is_there else ""
            await_description(client, f"/{space}/robot_".replace("//", "/"))
        request = SpawnEntity.Request(entity_resource=resource, allow_renaming=True)
        request.name = chosen.name or "robot"
        request.entity_namespace = space and f"/{space}"
        place = request.initial_pose.pose
        place.position.x, place.position.y, place.position.z = chosen.x, chosen.y, chosen.z
        place.orientation = quaternion(chosen.Y)
        print(f"spawned {_ask(client, request)}", flush=True)


def _text_of(resource: Any) -> str:
    path = Path(resource.uri)
    there = resource.uri and path.is_file()
    return resource.resource_string or (read_text(path, 20_000_000) if there else "")


def space_of(own: str, topic: str, text: str) -> str:
    """Return a robot's namespace: its spawner's, or that of its description and controllers."""
    own, described = own.strip("/"), topic.strip("/").rpartition("/")[0]
    controls = re.search(rf"<namespace>\s*/?{re.escape(described)}\s*</", text) is not None
    return described if described and (controls or (own and topic.startswith("/"))) else own


def await_description(client: SimulatorClient, start: str) -> bool:
    """Wait for who describes a robot, where the simulator does not: longer where it was launched.

    Args:
        start: Of its names, with the namespace, as `/robot_`.
    """
    launched = f"{start}state_publisher" in os.environ[LAUNCHED].split()
    count, topic = client.client.count_publishers, f"{start}description"
    patience = _PATIENCE if launched else _PUBLISHER_STARTS
    return client.run_until(lambda: bool(count(topic)), patience, required=False)


def _ask(client: SimulatorClient, request: Any) -> str:
    """Spawn as soon as the world takes it; say once why it does not, where it takes its time."""
    begun, said = time.monotonic(), False
    while True:
        try:
            return str(client.ask(SpawnEntity, "/spawn_entity", request).entity_name)
        except SimulatorError as error:
            waited = time.monotonic() - begun
            if waited > _PATIENCE or f"({Result.RESULT_INCORRECT_STATE})" not in str(error):
                raise
            if waited > _PATIENCE_UNTOLD and not said:
                said = True
                print(f"waits: {error}", flush=True)
            client.run_until(lambda: False, 1.0, required=False)


def _received(client: SimulatorClient, topic: str) -> str:
    """Return a robot's description from a topic."""
    received: list[str] = []
    profile: QoSProfile = qos.LATCHED
    client.client.create_subscription(String, topic, lambda m: received.append(m.data), profile)
    if not client.run_until(lambda: bool(received), _PATIENCE, required=False):
        raise Ros2Error(f"nobody publishes a robot's description on {topic}")
    return received[0]


def _written(text: str, folder: str) -> Path:
    path = Path(folder, "robot.sdf" if "<sdf" in text else "robot.urdf")
    path.write_text(text, encoding="utf-8")
    return path
