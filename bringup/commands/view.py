"""`view`: the robot, its map and its plans in a browser, with tools to command it."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

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
        "--config", type=Path, metavar="FILE.rviz", help="RViz's: its fixed frame and displays"
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
    from bringup.viewing.drawing.visual_model import mesh_finder
    from bringup.viewing.robot.robot_side import RobotOptions, RobotSide
    from bringup.viewing.rviz_file import read_rviz

    options.extend_search(arguments)
    config = None if arguments.config is None else read_rviz(arguments.config)
    frame = arguments.frame or (config and config.fixed_frame) or "map"
    topics, layers = (config.topics, config.layers) if config else ({}, None)
    server = open_server(arguments.host, _PORT if arguments.port is None else arguments.port)
    robot = RobotSide(RobotOptions(arguments.namespace, frame, arguments.cmd_vel, topics))
    viewer = Viewer(server, robot, mesh_finder(), layers)
    if config:
        show(f"{arguments.config}: {', '.join(sorted(config.layers))}, drawn in {frame}")
        for name in config.left_out:
            show(f"not shown here: {name}")
    show(f"open http://{arguments.host}:{server.get_port()} in a browser; Ctrl-C ends it")
    while not stopped():
        viewer.step()
    robot.close()
    server.stop()


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
    from bringup.viewing.drawing.visual_model import mesh_finder
    from bringup.viewing.rerun.show import watch

    options.extend_search(arguments)
    watch(arguments.save, arguments.web, mesh_finder(), show, stopped)
