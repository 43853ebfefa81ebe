"""One log file a run, below `~/.arjuna/log`."""

from __future__ import annotations

import re
import shutil
from datetime import datetime
from logging import Formatter, Logger
from logging.handlers import RotatingFileHandler
from pathlib import Path

RUNS_KEPT = 20
_RUN = re.compile(r"\d{8}-\d{6}-[a-z-]+(-\d+)?")
_FILE = "log.txt"


class RunLog:
    """Writes the lines of a run with the time; the oldest runs' folders go.

    Args:
        root: The folder of all runs; `~/.arjuna/log` by default.
        largest: Size of the file [bytes]; as many again of what was before are kept.

    Attributes:
        path: The file; None where it cannot be written.
    """

    def __init__(
        self, command: str, started: datetime, root: Path | None = None, largest: int = 10_000_000
    ) -> None:
        root = Path.home() / ".arjuna" / "log" if root is None else root
        self._logger = Logger(command)
        self.path: Path | None = None
        try:
            self.path = _new_folder(root, f"{started:%Y%m%d-%H%M%S}-{command}") / _FILE
            handler = RotatingFileHandler(self.path, maxBytes=largest, backupCount=1)
        except OSError:
            return  # a full disk or a foreign home must not stop the robot
        handler.setFormatter(Formatter("%(asctime)s.%(msecs)03d %(message)s", "%Y-%m-%d %H:%M:%S"))
        self._logger.addHandler(handler)
        _remove_old(root)

    def write(self, line: str) -> None:
        """Write a line."""
        self._logger.info("%s", line)

    def close(self) -> None:
        """Close the file."""
        for handler in list(self._logger.handlers):
            self._logger.removeHandler(handler)
            handler.close()


def _new_folder(root: Path, name: str) -> Path:
    """Make the folder of a run; a second one of the same second gets a number."""
    number, folder = 1, root / name
    while folder.exists():
        number += 1
        folder = root / f"{name}-{number}"
    folder.mkdir(parents=True)
    return folder


def _remove_old(root: Path) -> None:
    runs = sorted(folder for folder in root.iterdir() if _RUN.fullmatch(folder.name))
    for folder in runs[:-RUNS_KEPT]:
        shutil.rmtree(folder, ignore_errors=True)
