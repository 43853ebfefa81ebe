"""A client's session: Ctrl-C, whenever it comes."""

from __future__ import annotations

import subprocess
import sys

import pytest

pytestmark = pytest.mark.ros
INTERRUPTED = """
import os, signal, sys
from std_msgs.msg import String
from bringup.client.session import Connection

def interrupt(number, frame):
    raise KeyboardInterrupt

def run(delay):
    session = Connection("interrupted", parameter_services=True)
    for k in range(5):
        session.client.create_subscription(String, f"topic_{k}", lambda message: None, 10)
    signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, delay)
    try:
        while True:
            session.spin_once()
    except KeyboardInterrupt:
        session.close()

ends = []
for k in range(20):
    if not (child := os.fork()):
        run(1e-4 + 2e-5 * k)
        os._exit(0)
    ends.append(os.waitpid(child, 0)[1])
print(*ends)
"""
"""While the executor adds entities: there, a third of them aborted the process."""


def test_ctrl_c_while_it_begins_to_spin_ends_it_in_order() -> None:
    command = [sys.executable, "-c", INTERRUPTED]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60.0)
    assert done.stdout.split() == ["0"] * 20, done.stderr
