"""A recording, or a running robot, in rerun: in a file, its window or a browser's page."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import rerun as rr
import rerun_cli

from arjuna_core.bags.reader import Bag
from arjuna_core.errors import ArjunaError, InputFileError
from bringup.viewing.rerun.scene import Scene
from bringup.viewing.rerun.stream import Stream

_APPLICATION = "arjuna"
_DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY")
_HOST = "127.0.0.1"
_MEMORY = "2GiB"  # of what the viewer is given; beyond that the oldest is dropped


class OutputError(ArjunaError):
    """There is nowhere to show it."""


class Output:
    """A rerun recording that goes to a file or to a viewer on this machine; a context manager.

    rerun's own `spawn` and `serve_grpc` listen on every network; its program takes an address.

    Args:
        save: The file to write; None to show it.

    Raises:
        OutputError: The file exists already or cannot be written, there is no display, or the
            viewer does not start.
    """

    def __init__(self, save: Path | None, web: bool, show: Callable[[str], None]) -> None:
        self.recording = rr.RecordingStream(_APPLICATION)
        self.recording.set_log_time_enabled(False)  # the robot's time is the only one that counts
        self.recording.set_log_tick_enabled(False)
        self._viewer: subprocess.Popen[bytes] | None = None
        if save is not None:
            _refuse_existing(save)
            self.recording.save(save)
            return
        port = _free_port()
        self._viewer = _start_viewer(port, web, show)
        self.recording.connect_grpc(f"rerun+http://{_HOST}:{port}/proxy")

    def wait(self) -> None:
        """Wait until the viewer is closed; where there is none, return at once."""
        self.recording.flush()
        if self._viewer is not None:
            self._viewer.wait()

    @property
    def open(self) -> bool:
        """True while the data are still seen or saved."""
        return self._viewer is None or self._viewer.poll() is None

    def __enter__(self) -> Output:
        return self

    def __exit__(self, *ended: object) -> None:
        if self.open:
            self.recording.flush()
        self.recording.disconnect()
        if self._viewer is not None:
            self._viewer.terminate()
            self._viewer.wait()


def _refuse_existing(path: Path) -> None:
    if path.exists():
        raise OutputError(f"{path} exists already and is not overwritten")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    except OSError as error:
        raise OutputError(f"{path} cannot be written: {error.strerror}") from error


def _start_viewer(port: int, web: bool, show: Callable[[str], None]) -> subprocess.Popen[bytes]:
    if not web and sys.platform == "linux" and not any(os.environ.get(each) for each in _DISPLAYS):
        raise OutputError(
            "there is no display for rerun's window; valid: --web for a browser,"
            " --save FILE.rrd for a file"
        )
    program = str(Path(rerun_cli.__file__).with_name("rerun"))  # the script only starts it
    command = [program, "--bind", _HOST, "--port", str(port), "--server-memory-limit", _MEMORY]
    page = _free_port()
    if web:
        command += ["--web-viewer", "--web-viewer-port", str(page)]
    environment = dict(os.environ, BROWSER="true")  # the link is for the user to open
    try:
        viewer = subprocess.Popen(  # noqa: S603 - rerun's own program, no shell
            command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment
        )
    except OSError as error:
        raise OutputError(
            f"{program} does not start: {error.strerror}; run 'make setup'"
        ) from error
    _wait_for(viewer, port)
    if web:
        address = f"rerun%2Bhttp%3A%2F%2F{_HOST}%3A{port}%2Fproxy"
        show(f"open http://{_HOST}:{page}/?url={address} in a browser; Ctrl-C ends it")
    return viewer


def _wait_for(viewer: subprocess.Popen[bytes], port: int, patience: float = 20.0) -> None:
    deadline = time.monotonic() + patience
    while time.monotonic() < deadline:
        try:
            viewer.wait(timeout=0.1)
        except subprocess.TimeoutExpired:
            with socket.socket() as probe:
                if probe.connect_ex((_HOST, port)) == 0:
                    return
        else:
            raise OutputError(f"rerun's viewer ended at once, with code {viewer.returncode}")
    viewer.terminate()
    viewer.wait()
    raise OutputError(f"rerun's viewer does not listen within {patience:.0f} s")


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind((_HOST, 0))
        return int(probe.getsockname()[1])


def replay(bag: Bag, save: Path | None, web: bool, show: Callable[[str], None]) -> None:
    """Show a recording, or write it to a file of rerun's.

    Raises:
        InputFileError: It holds nothing that can be shown.
        OutputError: There is nowhere to show it.
    """
    with Output(save, web, show) as output:
        stream = Stream(output.recording, patience=5.0)
        scene = Scene(stream)
        names = {name for name, topic in bag.topics.items() if scene.shows(topic.type_name)}
        if not names:
            valid = ", ".join(sorted(bag.topics)) or "none"
            raise InputFileError(bag.path, f"holds nothing that can be shown; its topics: {valid}")
        for message in bag.messages(names.__contains__):
            scene.take(message.topic, message.time, message.data)
            if not output.open:
                break
        stream.flush()
        for note in [*scene.notes, *bag.problems]:
            show(f"note: {note}")
        hidden = ", ".join(sorted(set(bag.topics) - scene.topics)) or "none"
        show(f"{stream.now:.1f} s, {len(scene.topics)} topics shown; not shown: {hidden}")
        output.wait()


def watch(
    save: Path | None, web: bool, show: Callable[[str], None], stopped: Callable[[], bool]
) -> None:
    """Show the running robot until it is stopped or the viewer is closed.

    Raises:
        OutputError: There is nowhere to show it.
    """
    from rclpy.node import Node

    from arjuna_core.ros.context import new_context
    from bringup.recording.listener import TopicListener

    poll, discover = 0.05, 0.5  # [s]
    with Output(save, web, show) as output:
        stream = Stream(output.recording, poll)
        scene = Scene(stream)
        context = new_context()
        node = Node("viewer", context=context, start_parameter_services=False, enable_rosout=False)
        listener, pause, due = TopicListener(node), threading.Event(), 0.0
        try:
            while not stopped() and output.open:
                now = time.monotonic()
                if now >= due:
                    listener.discover(lambda name, kind: scene.shows(kind))
                    due = now + discover
                for message in listener.take():
                    scene.take(message.topic, message.received, message.data)
                stream.flush()
                pause.wait(poll)
        finally:
            node.destroy_node()
            context.shutdown()
        for note in scene.notes:
            show(f"note: {note}")
