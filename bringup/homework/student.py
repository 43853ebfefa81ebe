"""The process of a submission: a sandbox in which a plain rclpy file runs in lock-step.

Its time is the simulator's, and passes where the program lets it: in `rclpy.spin` and its like, in
`time.sleep` and in a `Robot`'s waiting. The grader is at the other end of a pipe of lines.
"""

from __future__ import annotations

import json
import os
import random
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

from bringup.homework.sandbox import SHARED, SandboxError, confine, limit, seal, separate

CPU, MEMORY, FOLDER, PRINTED = 120, 1 << 29, 1 << 24, 1 << 20
"""The most of a program's CPU time [s], memory, folder and output [bytes]."""
_PACKAGES = ("arjuna", "arjuna_core", "arjuna_nav", "arjuna_sim", "bringup", "ros_packages")


class Pipe:
    """The end of the pipe that the grader holds the other end of."""

    def __init__(self, reader: int, writer: int) -> None:
        self._lines = os.fdopen(reader, "rb")
        self._writer = writer

    def receive(self) -> dict[str, Any]:
        """Return what comes next; without a grader there is nothing to do any more."""
        line = self._lines.readline()
        if not line:
            os._exit(1)
        return dict(json.loads(line))

    def send(self, message: dict[str, Any]) -> None:
        """Send a message."""
        data = json.dumps(message).encode() + b"\n"
        while data:
            data = data[os.write(self._writer, data) :]


def main() -> None:
    """Close the sandbox, then run the submission that comes through the pipe."""
    pipe, work = Pipe(int(sys.argv[1]), int(sys.argv[2])), Path(sys.argv[3])
    try:
        separated = separate(work, FOLDER)
        memory = confine(_readable(), [work, *([SHARED] if separated else [])])
    except SandboxError as error:
        pipe.send({"refused": str(error)})
        return
    os.chdir(work)
    hello = pipe.receive()
    for name, text in hello["files"].items():
        (work / name).write_bytes(bytes.fromhex(text))
    path = work / hello["main"]
    run = _function(pipe, path) if hello["function"] else _node(pipe, path, hello)
    limit(CPU, PRINTED)
    _be_the_same_every_time()
    try:
        seal(memory, MEMORY)
    except SandboxError as error:
        pipe.send({"refused": str(error)})
        return
    pipe.send({"ready": True})
    reason = _reason_of(run, path)
    sys.stdout.flush()
    sys.stderr.flush()
    pipe.send({"ended": reason})
    os._exit(0)


def _readable() -> list[Path]:
    """Return what a program needs to read: Python, its packages and libraries, and ROS'."""
    prefix, base = Path(sys.prefix), Path(sys.base_prefix)
    ours = Path(__file__).resolve().parents[2]
    return [
        *(prefix / name for name in ("lib", "lib64", "pyvenv.cfg", "share/ament_index")),
        *(base / name for name in ("lib", "lib64")),
        *(Path(name) for name in ("/usr/lib", "/usr/lib64", "/lib", "/lib64", "/etc/ld.so.cache")),
        *(ours / name for name in _PACKAGES),
    ]


def _be_the_same_every_time() -> None:
    """Seed what is drawn without a seed."""
    import numpy as np

    random.seed(0)
    np.random.seed(0)  # noqa: NPY002 - students' programs use it
    make, drawn = np.random.default_rng, random.Random(0)  # noqa: S311 - no secret
    np.random.default_rng = lambda seed=None: make(drawn.getrandbits(64) if seed is None else seed)
    os.urandom = drawn.randbytes


def _reason_of(run: Callable[[], None], path: Path) -> str:
    """Run a program; return why it ended, "" where it came to its end."""
    try:
        run()
    except SystemExit as error:
        return "" if error.code in (None, 0) else f"it ended by sys.exit({error.code!r})"
    except BaseException as error:  # noqa: BLE001 - whatever it is, it is the submission's
        trace, lines = error.__traceback__, []
        while trace and trace.tb_frame.f_code.co_filename != str(path):
            trace = trace.tb_next  # what is above is ours
        traceback.print_exception(type(error), error, trace)
        for frame in traceback.extract_tb(trace):
            lines += [frame.lineno] if frame.filename == str(path) else []
        where = f" in line {lines[-1]}" if lines else ""
        return f"{type(error).__name__}{where}: {error}"[:300]
    return ""


def _function(pipe: Pipe, path: Path) -> Callable[[], None]:
    """Return what answers calls of a file's functions."""
    import runpy

    def run() -> None:
        names = runpy.run_path(str(path), run_name="homework")
        pipe.send({"loaded": True})
        while True:
            call = pipe.receive()
            if call["name"] not in names:
                pipe.send({"error": f"there is no function {call['name']}"})
                continue
            try:
                pipe.send({"result": names[call["name"]](*call["arguments"])})
            except Exception as error:  # noqa: BLE001 - the submission's
                pipe.send({"error": f"{type(error).__name__}: {error}"[:300]})

    return run


def _node(pipe: Pipe, path: Path, hello: dict[str, Any]) -> Callable[[], None]:
    """Return what runs a file as `ros2 run FILE` does."""
    from bringup.homework.rclpy_in_step import Steps
    from bringup.ros2.programs.python_file import run_file

    Steps(pipe.send, pipe.receive, hello["listen"], hello["publish"]).install()
    return lambda: run_file(path, [])


if __name__ == "__main__":
    main()
