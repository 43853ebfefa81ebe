"""The destination of rerun's data: a file, its window, or its page in a browser."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import rerun as rr
import rerun_cli

from arjuna_core.errors import ArjunaError

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
        web: Whether to show it in a browser instead of rerun's window.
        show: Takes lines for the user.

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
