"""`python -m bringup sim` as a person runs it: real processes, real time."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from tests.helpers.processes import Lines, ended

pytestmark = [pytest.mark.ros, pytest.mark.system]
ACTIVE = "Managed nodes are active"


@pytest.fixture(autouse=True)
def _own_domain_and_home(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "91")
    monkeypatch.setenv("HOME", str(tmp_path))


def _children(pid: int) -> list[int]:
    listed = Path(f"/proc/{pid}/task/{pid}/children").read_text()
    return [int(word) for word in listed.split()]


def _imports(pid: int) -> bool:
    """Return whether a process of ours is at its imports, or done with them."""
    of = Path(f"/proc/{pid}")
    return b"bringup.host" in (of / "cmdline").read_bytes() and "numpy" in (of / "maps").read_text()


def test_sim_comes_up_dies_comes_up_again_and_stops_cleanly() -> None:
    with Lines("-m", "bringup", "sim") as bringup:
        bringup.wait_for(ACTIVE)
        bringup.wait_for("3 nodes active after")
        assert len(bringup.seen) == 3, "the log, the manager's line, and this one"
        (first,) = _children(bringup.process.pid)
        os.kill(first, signal.SIGKILL)
        bringup.wait_for("sim died (SIGKILL); it starts again in 0.2 s")
        bringup.wait_for(ACTIVE, 2)
        (second,) = _children(bringup.process.pid)
        bringup.process.send_signal(signal.SIGINT)
        assert bringup.read_to_end() == 0
        assert ended(second)


def test_a_killed_bringup_leaves_no_node_behind() -> None:
    """Nor does a second simulator, which says what is wrong and ends."""
    with Lines("-m", "bringup", "sim") as first:
        first.wait_for(ACTIVE)
        with Lines("-m", "bringup", "sim") as second:
            assert second.read_to_end() == 2
            assert second.matching("a simulator runs already: /sim in domain 91; end it")
        assert not first.matching("another process has")
        (host,) = _children(first.process.pid)
        first.process.kill()
        first.process.wait()
        assert ended(host)


def test_stopped_while_it_starts_it_ends_without_a_traceback() -> None:
    with Lines("-m", "bringup", "nav", "--slam") as bringup:
        bringup.wait_for("log: ")
        while not any(map(_imports, _children(bringup.process.pid))):
            assert bringup.process.poll() is None
        bringup.process.send_signal(signal.SIGINT)
        assert bringup.read_to_end() == 0
        assert not bringup.matching("Traceback")


def test_a_reader_that_goes_away_stops_the_robot() -> None:
    with Lines("-m", "bringup", "sim", "--log-level", "debug") as bringup:
        bringup.wait_for(ACTIVE)
        (host,) = _children(bringup.process.pid)
        assert bringup.process.stdout is not None
        bringup.process.stdout.close()
        os.kill(host, signal.SIGKILL)  # what is said of it has no reader
        assert bringup.process.wait(timeout=20.0) == 0


def test_without_a_simulator_it_logs_what_it_waits_for(tmp_path: Path) -> None:
    with Lines("-m", "bringup", "slam", "--namespace", "robot1") as bringup:
        (line,) = bringup.wait_for("waiting for slam: /robot1/clock: is ")
        assert "(ROS_DOMAIN_ID=91, --namespace robot1 here;" in line
        bringup.process.send_signal(signal.SIGINT)
        assert bringup.read_to_end() == 0
    (log,) = (tmp_path / ".arjuna" / "log").glob("*-slam/log.txt")
    assert line in log.read_text()
