"""The bridge between a ROS graph and Foxglove's WebSocket protocol.

Source: the protocol's specification (`ws-protocol`, docs/spec.md), and the app, which takes a
server for one of ROS 2 by its `ROS_DISTRO`: only then it publishes goals and poses from its scene.
"""

from __future__ import annotations

import json
import re
import struct
import time
from collections.abc import Callable
from typing import Any

from rclpy.context import Context
from rosgraph_msgs.msg import Clock

from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import MESH_BYTES_MAX, read_bytes
from arjuna_core.ros import qos
from bringup.viewing.drawing.visual_model import find_mesh
from bringup.viewing.foxglove.channels import Channels, Publications
from bringup.viewing.foxglove.connection_graph import ConnectionGraph
from bringup.viewing.foxglove.graph_server import MALFORMED, GraphServer
from bringup.viewing.foxglove.parameters import Parameters
from bringup.viewing.foxglove.server import ERROR, Client, Server
from bringup.viewing.foxglove.service_calls import ServiceCalls
from bringup.viewing.robot.services import Services

PORT = 8765
"""Foxglove's own."""
_CAPABILITIES = "clientPublish parameters parametersSubscribe services connectionGraph assets"
_ASSET = re.compile(
    r"package://(?:[-\w%.]+/)+[-\w%]+\.(?:dae|fbx|glb|gltf|jpe?g|mtl|obj|png|stl|tiff?|urdf|webp|xacro)",
    re.IGNORECASE,
)
"""The files that foxglove_bridge gives out unless told otherwise: pictures, meshes and robots."""


class Bridge(GraphServer):
    """Serves a robot to Foxglove.

    Args:
        port: The port; 0 for any.

    Raises:
        BridgeError: The address is taken, or not this machine's.
    """

    def __init__(self, host: str, port: int = PORT, context: Context | None = None) -> None:
        server = Server(host, port)
        super().__init__(server, "foxglove_bridge", context, start_parameter_services=False)
        node, self._session = self._node, str(time.time_ns())
        self._channels = Channels(node, self._clients)
        self._publications = Publications(node)
        self._parameters = Parameters(node, Services(node))
        self._calls = ServiceCalls(node, self._clients)
        self._graph = ConnectionGraph(node)
        self._clock: Any = None
        self._texts: dict[str, Callable[[Client, Any], None]] = {
            "subscribe": self._channels.subscribe,
            "unsubscribe": self._channels.unsubscribe,
            "advertise": self._publications.advertise,
            "unadvertise": self._publications.unadvertise,
            "getParameters": self._parameters.get,
            "setParameters": self._parameters.set,
            "subscribeParameterUpdates": self._parameters.subscribe,
            "unsubscribeParameterUpdates": self._parameters.unsubscribe,
            "subscribeConnectionGraph": self._graph.subscribe,
            "unsubscribeConnectionGraph": self._graph.forget,
            "fetchAsset": self._fetch,
        }
        self._binaries: dict[int, Callable[[Client, bytes], None]] = {
            1: self._publications.publish,
            2: self._calls.call,
        }

    def _refresh(self) -> None:
        for part in (self._channels, self._calls, self._graph):
            part.refresh()

    def _tick(self) -> None:
        self._parameters.tick()

    def _greet(self, client: Client) -> None:
        timed = self._node.count_publishers("/clock") > 0
        client.clock = 0 if timed else None
        if timed and self._clock is None:
            self._clock = self._node.create_subscription(
                Clock, "/clock", self._pass_time_on, qos.CLOCK
            )
        client.send_message(
            "serverInfo",
            name="Arjuna",
            capabilities=[*_CAPABILITIES.split(), *(["time"] if timed else [])],
            supportedEncodings=["cdr"],
            metadata={"ROS_DISTRO": "jazzy"},
            sessionId=self._session,
        )
        self._channels.greet(client)
        self._calls.greet(client)

    def _pass_time_on(self, message: Clock) -> None:
        now = message.clock.sec * 10**9 + message.clock.nanosec
        for client in self._clients:
            if client.clock is not None:
                client.clock = now
                client.send_binary(2, "Q", now)

    def _forget(self, client: Client) -> None:
        for part in (self._channels, self._publications, self._parameters, self._graph):
            part.forget(client)

    def _handle(self, client: Client, message: str | bytes) -> None:
        try:
            if isinstance(message, bytes):
                self._binaries[message[0]](client, message[1:])
            else:
                fields = json.loads(message)
                self._texts[fields["op"]](client, fields)
        except (*MALFORMED, struct.error) as error:
            client.send_status(ERROR, f"Invalid message: {type(error).__name__}: {error}")

    def _fetch(self, client: Client, message: Any) -> None:
        """Send a file of a package, one of those that a robot's description names."""
        uri, data, problem = str(message["uri"]), b"", ""
        if ".." in uri or not _ASSET.fullmatch(uri):
            problem = f"'{uri}' is not given out; valid: meshes and pictures of package://"
        elif (path := find_mesh(uri)) is None:
            problem = f"'{uri}' is not found"
        else:
            try:
                data = read_bytes(path, MESH_BYTES_MAX)
            except InputFileError as error:
                problem = str(error)
        text = problem.encode()
        head = message["requestId"], bool(text), len(text)
        client.send_binary(4, "IBI", *head, data=text + data)
