"""`view`: see the robot in a browser, and command it there."""

from __future__ import annotations

import argparse
import signal
from pathlib import Path
from typing import TYPE_CHECKING

from bringup.parameters import robot_options

if TYPE_CHECKING:
    from bringup.viewing.drawing.looks import FindMesh

_PORT = 8080


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        metavar="ADDRESS",
        help="address to serve on; who reaches it can drive the robot (%(default)s)",
    )
    parser.add_argument(
        "--port", type=int, metavar="N", help=f"port; the next free one if it is taken ({_PORT})"
    )
    parser.add_argument(
        "--frame", default="map", metavar="FRAME", help="frame to draw in (%(default)s)"
    )
    parser.add_argument("--namespace", default="", metavar="NAME", help="the robot's namespace")
    parser.add_argument(
        "--cmd-vel", default="cmd_vel", metavar="TOPIC", help="to drive by hand (%(default)s)"
    )
    parser.add_argument(
        "--package-path",
        type=Path,
        action="append",
        default=[],
        metavar="DIR",
        help="folder of ROS packages with the robot's meshes; may be given again",
    )


def run(arguments: argparse.Namespace) -> int:
    """Serve the viewer until it is stopped.

    Raises:
        ServerError: It cannot be served at the address.
    """
    from bringup.terminal import show
    from bringup.viewing.browser.server import open_server
    from bringup.viewing.browser.viewer import Viewer
    from bringup.viewing.robot.robot_side import RobotOptions, RobotSide

    robot_options.extend_search(arguments)
    stopping: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda signal_number, frame: stopping.append(signal_number))
    server = open_server(arguments.host, _PORT if arguments.port is None else arguments.port)
    options = RobotOptions(arguments.namespace, arguments.frame, arguments.cmd_vel)
    robot = RobotSide(options)
    viewer = Viewer(server, robot, _mesh_finder())
    show(f"open http://{arguments.host}:{server.get_port()} in a browser; Ctrl-C ends it")
    while not stopping:
        viewer.step()
    robot.close()
    server.stop()
    return 0


def _mesh_finder() -> FindMesh:
    """Return what finds meshes in the packages of the environment and below this folder."""
    from arjuna_sim.files.search_path import EscapeError, SearchPath

    def find(uri: str) -> Path | None:
        try:
            return SearchPath.of().find(Path.cwd() / "robot.urdf", uri)
        except EscapeError:
            return None

    return find
