"""The guides' own text, typed: each row's command in a shell, beside the robot that it needs.

The rows are facts of the five guides: a command, a name, a value, and the line where it stands.
`python -m tests.foreign.guides.typed --guides FOLDER` types all rows of all guides, with the
listings of the guides' own files where the folder has them, and prints a table.
"""

from __future__ import annotations

import argparse
import os
import pty
import re
import select
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from pathlib import Path

import yaml

from arjuna_core.files.shipped import shipped_file
from bringup.terminal import show

FOLDER = Path(__file__).parent
ROOT = shipped_file("docs").parent
GUIDES = ("000", "001", "002", "003", "004")
_LIMIT = 60.0  # [s] for what ends by itself
_UP, _LOOK = " nodes active after ", 0.2  # what `sim`, `slam` and `nav` say last; [s]
_KEY = 0.4  # [s] from one key to the next
_NAV = f"nav --map {ROOT}/maps/arjuna_room.yaml"
BESIDE: Mapping[str, tuple[str, ...]] = {
    "": (),
    "sim": ("sim",),
    "slam": ("sim", "slam"),
    "nav": ("sim", _NAV),
    "wall_nav": ("sim", f"robot --map {ROOT}/maps/arjuna_room.yaml"),
    "blind_nav": (f"sim --robot {FOLDER}/blind.urdf", _NAV),
    "udacity": (
        f"sim --robot {ROOT}/urdf/udacity_bot.xacro --world {ROOT}/worlds/race_track.world",
        f"nav --map {ROOT}/maps/race_track.yaml --params udacity.yaml",
    ),
}
"""What runs beside the rows of each kind; `udacity.yaml` is made by a row that needs none."""


@dataclass(frozen=True)
class Row:
    """One command, file, listing or promise of a guide.

    Attributes:
        guide: The guide's number.
        at: Its line in the guide.
        kind: `command`, `file`, `listing` or `promise`.
        typed: As the guide has it.
        here: How the same is done here, where the guide's own words are of a program that is not.
        needs: `hardware`, `packages` (of a distribution) or `package` (of one's own); not typed.
        beside: What runs: a key of `BESIDE`.
        file: The file to write first, with `text`, or with `lines` of the guide.
        text: What it holds.
        lines: Of the guide: first and last.
        also: Other files, with their lines.
        keys: Pressed in its terminal, one by one.
        ends: After how long it is ended with Ctrl-C [s].
        limit: After how long it has failed [s].
        shows: What its output must match.
        fails: True where its exit code must not be 0, "any" where it may be any.
    """

    guide: str
    at: int
    kind: str
    typed: str
    here: str = ""
    needs: str = ""
    beside: str = ""
    file: str = ""
    text: str = ""
    lines: Sequence[int] = ()
    also: Mapping[str, Sequence[int]] = field(default_factory=dict)
    keys: str = ""
    ends: float = 0.0
    limit: float = _LIMIT
    shows: str = ""
    fails: bool | str = False

    @property
    def name(self) -> str:
        """The position of the line in its guide."""
        return f"{self.guide}:{self.at}"

    @property
    def is_quick(self) -> bool:
        """Return whether it needs no robot, no keyboard and no guide's file."""
        return not (self.needs or self.beside or self.keys or self.ends or self.lines)


def rows(guide: str) -> list[Row]:
    """Return the rows of a guide."""
    entries = yaml.safe_load((FOLDER / f"{guide}.yaml").read_text(encoding="utf-8"))
    return [Row(guide=guide, **entry) for entry in entries]


def type_row(row: Row, folder: Path, guides: Path | None = None) -> tuple[bool, str]:
    """Type a row in a folder; return whether it did as it should, and what it printed.

    Args:
        row: The row.
        folder: Where it is typed, and the home of who types it.
        guides: The guides' own files, for listings.
    """
    listings = {**({row.file: row.lines} if row.lines else {}), **row.also}
    texts = {name: _cut(row.guide, lines, guides) for name, lines in listings.items()}
    for name, text in {**({row.file: row.text} if row.text else {}), **texts}.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    command = (row.here or row.typed).replace("/home/user", str(folder))
    code, printed = _run(command, folder, row)
    well = row.fails == "any" or (code != 0) == bool(row.fails)
    return well and re.search(row.shows, printed) is not None, printed


def _cut(guide: str, lines: Sequence[int], guides: Path | None) -> str:
    """Return lines of a guide."""
    if guides is None:
        raise FileNotFoundError("the guides' own files are not given")
    text = next(guides.glob(f"{guide}_*.txt")).read_text(encoding="utf-8").splitlines()
    return "\n".join(text[lines[0] - 1 : lines[1]]) + "\n"


def _run(command: str, folder: Path, row: Row) -> tuple[int, str]:
    """Run a command in bash, with its own terminal where keys are pressed."""
    environment = {
        **os.environ,
        "HOME": str(folder),
        "ARJUNA": str(ROOT),
        "PYTHONUNBUFFERED": "1",
        "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
    }
    leader, follower = pty.openpty() if row.keys else (None, subprocess.DEVNULL)
    with tempfile.TemporaryFile() as output:
        process = subprocess.Popen(
            ["bash", "-c", command],
            cwd=folder,
            env=environment,
            stdin=follower,
            stdout=follower if row.keys else output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        if leader is not None:
            printed = _press(row.keys, leader, process)
        ended = _wait(process, row.ends, row.limit)
        if leader is None:
            output.seek(0)
            printed = output.read().decode("utf-8", "replace")
    code = 0 if row.keys or (ended and row.ends) else process.returncode
    for descriptor in () if leader is None else (leader, follower):
        os.close(descriptor)
    return code, printed


def _press(keys: str, leader: int, process: subprocess.Popen[bytes]) -> str:
    """Press keys in a terminal, once something has been printed there; return all of it."""
    printed, left, deadline = b"", list(keys), time.monotonic() + _LIMIT
    due = 0.0
    while time.monotonic() < deadline and (left or process.poll() is None):
        if select.select([leader], [], [], 0.1)[0]:
            with suppress(OSError):
                printed += os.read(leader, 65536)
        if not due and printed:
            due = time.monotonic() + 5.0 * _KEY  # it finds the robot first
        if due and left and time.monotonic() >= due:
            os.write(leader, left.pop(0).encode())
            due = time.monotonic() + _KEY
    return printed.decode("utf-8", "replace")


def _wait(process: subprocess.Popen[bytes], ends: float, limit: float) -> bool:
    """Wait for the end, as Ctrl-C brings it after a time [s], or by force.

    Returns:
        Whether it had to be ended.
    """
    ended = False
    for seconds, number in ((ends or limit, signal.SIGINT), (15.0, signal.SIGKILL)):
        with suppress(subprocess.TimeoutExpired):
            process.wait(seconds)
            break
        os.killpg(process.pid, number)
        ended = True
    process.wait()
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)  # what it left in the background
    return ended


def beside(name: str, folder: Path, opened: ExitStack) -> None:
    """Start what runs beside rows; its output lies in the folder as `sim.log`, `nav.log`.

    Raises:
        TimeoutError: It does not come up.
    """
    for words in BESIDE[name]:
        program = [sys.executable, "-m", "bringup", *words.split()]
        log = folder / f"{program[3]}.log"
        with log.open("wb") as output:
            process = subprocess.Popen(
                program, cwd=folder, stdin=subprocess.DEVNULL, stdout=output, stderr=output
            )
        opened.callback(_end, process)
        deadline = time.monotonic() + _LIMIT
        while _UP not in log.read_text(encoding="utf-8"):
            if time.monotonic() > deadline or process.poll() is not None:
                raise TimeoutError(f"'{words}' is not up:\n{log.read_text(encoding='utf-8')}")
            with suppress(subprocess.TimeoutExpired):
                process.wait(_LOOK)


def _end(process: subprocess.Popen[bytes]) -> None:
    process.send_signal(signal.SIGINT)
    try:
        process.wait(_LIMIT / 2.0)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def main(argv: Sequence[str] | None = None) -> int:
    """Type all rows and print a table; return 1 where one did not do as it should."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--guides", type=Path, help="folder of the guides' own files")
    parser.add_argument("--only", nargs="*", help="rows, as 002:1040, or guides, as 002")
    parser.add_argument("--quiet", action="store_true", help="print no output of what fails")
    arguments = parser.parse_args(argv)
    every = [row for guide in GUIDES for row in rows(guide)]
    if arguments.only:
        every = [row for row in every if {row.guide, row.name} & set(arguments.only)]
    counts: dict[str, int] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in BESIDE:
            counted = [row for row in every if row.beside == name]
            with ExitStack() as opened:
                if any(not row.needs for row in counted):
                    beside(name, Path(folder), opened)
                for row in counted:
                    verdict, printed = _verdict(row, Path(folder), arguments.guides)
                    counts[verdict] = counts.get(verdict, 0) + 1
                    show(f"{row.name:9}{row.kind:9}{verdict:18}{row.typed[:70]}")
                    if verdict == "NOT" and not arguments.quiet:
                        show("    " + printed[-900:].replace("\n", "\n    "))
    show(str(dict(sorted(counts.items()))))
    return 1 if counts.get("NOT") else 0


def _verdict(row: Row, folder: Path, guides: Path | None) -> tuple[str, str]:
    if row.needs:
        return f"needs {row.needs}", ""
    if (row.lines or row.also) and guides is None:
        return "no guide", ""
    well, printed = type_row(row, folder, guides)
    return ("as typed" if not row.here else "by another way") if well else "NOT", printed


if __name__ == "__main__":
    sys.exit(main())
