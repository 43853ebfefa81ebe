"""`view`: the robot, its map and its plans in a browser, with tools to command it."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from bringup.parameters import options
from bringup.terminal import stopped_by_signals

EXAMPLES = ("view", "view --foxglove", "view --rerun --save drive.rrd")

_PORT = 8080  # as viser serves by default


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--foxglove",
        action="store_true",
        help="serve Foxglove (ws://...) instead: all topics as they are",
    )
    parser.add_argument(
        "--rerun", action="store_true", help="show it in rerun instead: its window, or"
    )
    parser.add_argument("--web", action="store_true", help="rerun's page for a browser, or")
    parser.add_argument("--save", type=Path, metavar="FILE.rrd", help="a file for rerun")
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        metavar="ADDRESS",
        help="address to serve on; who reaches it can drive the robot (%(default)s)",
    )
    parser.add_argument(
        "--port", type=int, metavar="N", help=f"port to serve on ({_PORT}; 8765 for Foxglove)"
    )
    parser.add_argument("--frame", metavar="FRAME", help="frame to draw in (map)")
    parser.add_argument(
        "--config",
        type=Path,
        metavar="FILE.rviz",
        help="RViz's: its fixed frame, displays and settings",
    )
    options.add(parser, *options.ROBOT_CHOICE)
    parser.add_argument(
        "--cmd-vel", default="cmd_vel", metavar="TOPIC", help="to drive by hand (%(default)s)"
    )
    options.add(parser, "--package-path", help=options.MESHES)


def run(arguments: argparse.Namespace) -> int:
    """Serve the viewer until it is stopped.

    Raises:
        ArjunaError: It cannot be served at the address.
    """
    rerun = arguments.rerun or arguments.web or arguments.save is not None
    serve = _serve_foxglove if arguments.foxglove else _serve_rerun if rerun else _serve_browser
    serve(arguments, stopped_by_signals().is_set)
    return 0


def _serve_browser(arguments: argparse.Namespace, stopped: Callable[[], bool]) -> None:
    from bringup.terminal import show
    from bringup.viewing.browser.server import open_server
    from bringup.viewing.browser.viewer import Viewer
    from bringup.viewing.displays.standard import STANDARD
    from bringup.viewing.robot.robot_side import RobotSide
    from bringup.viewing.rviz_file import read_rviz

    options.extend_search(arguments)
    config = None if arguments.config is None else read_rviz(arguments.config)
    frame = arguments.frame or (config and config.fixed_frame) or "map"
    server = open_server(arguments.host, _PORT if arguments.port is None else arguments.port)
    robot = RobotSide(None, arguments.namespace, frame, arguments.cmd_vel)
    displays = STANDARD if config is None else config.displays
    viewer = Viewer(server, robot, displays, config, _CpuWatch(robot))
    if config:
        shown = ", ".join(spec.name for spec in config.displays if spec.shown)
        show(f"{arguments.config}: {shown or 'no display'}, drawn in {frame}")
        if config.unsupported:
            show(f"not shown here, but kept: {', '.join(config.unsupported)}")
    show(f"open http://{arguments.host}:{server.get_port()} in a browser; Ctrl-C ends it")
    while not stopped():
        viewer.step()
    robot.close()
    server.stop()


class _CpuWatch:
    """Returns the share of a core that each node's process used since the last call, by name."""

    def __init__(self, robot: Any) -> None:
        self._robot = robot
        self._before: list[Any] = []
        self._looked = time.monotonic()

    def __call__(self) -> dict[str, float]:
        from bringup.doctor.machine import host_processes
        from bringup.doctor.table import cpu_shares, groups_by_node

        before, since = self._before, self._looked
        domain = self._robot.node.context.get_domain_id()
        self._before = [host for host in host_processes() if host.domain == domain]
        self._looked = time.monotonic()
        shares = cpu_shares(before, self._before, self._looked - since)
        groups, names = groups_by_node(), self._robot.node.get_node_names()
        return {name: shares[groups[name]] for name in names if groups.get(name) in shares}


def _serve_foxglove(arguments: argparse.Namespace, stopped: Callable[[], bool]) -> None:
    from bringup.terminal import show
    from bringup.viewing.foxglove.bridge import PORT, Bridge

    bridge = Bridge(arguments.host, PORT if arguments.port is None else arguments.port)
    show(f"open ws://{arguments.host}:{bridge.port} in Foxglove; Ctrl-C ends it")
    while not stopped():
        bridge.step()
    bridge.close()


def _serve_rerun(arguments: argparse.Namespace, stopped: Callable[[], bool]) -> None:
    from bringup.terminal import show
    from bringup.viewing.rerun.show import watch

    options.extend_search(arguments)
    watch(arguments.save, arguments.web, show, stopped)
