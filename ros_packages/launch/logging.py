"""The loggers of launch: to the screen, and to a file of the run."""

from __future__ import annotations

import logging
import os
import time
from pathlib import Path

_FORMAT = "[%(levelname)s] [%(name)s]: %(message)s"


class LaunchConfig:
    """The run's folder of log files, made when it is first written to."""

    folder: Path | None = None

    @property
    def log_dir(self) -> str:
        """Path of the folder: `~/.ros/log/TIME-HOST-PID`, as $ROS_LOG_DIR and $ROS_HOME say."""
        if self.folder is None:
            home = Path(os.environ.get("ROS_HOME") or Path.home() / ".ros")
            base = Path(os.environ.get("ROS_LOG_DIR") or home / "log")
            stamp = time.strftime("%Y-%m-%d-%H-%M-%S")
            self.folder = base / f"{stamp}-{os.uname().nodename}-{os.getpid()}"
        return str(self.folder)


class _Screen(logging.Handler):
    def emit(self, record: logging.LogRecord) -> None:
        print(self.format(record), flush=True)  # noqa: T201 - what it is there for


launch_config = LaunchConfig()


def get_logger(name: str | None = None) -> logging.Logger:
    """Return the logger of a name, which writes to the screen."""
    root = logging.getLogger("launch")
    if not root.handlers:
        handler = _Screen()
        handler.setFormatter(logging.Formatter(_FORMAT))
        root.addHandler(handler)
        root.setLevel(logging.INFO)
        root.propagate = False
    logger = root if name in (None, "launch") else logging.getLogger(f"launch.{name}")
    logger.name = name or "launch"
    return logger


def write_to_file(line: str) -> None:
    """Append a line to the run's `launch.log`; where that cannot be written it is left out."""
    try:
        folder = Path(launch_config.log_dir)
        folder.mkdir(parents=True, exist_ok=True)
        with (folder / "launch.log").open("a", encoding="utf-8") as file:
            file.write(f"{time.time():.7f} {line}\n")
    except OSError:
        return
