"""A robot finds what it calls compiled by the set-up, whatever its plug-ins."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from scripts.kernels import ROOT, read_list

pytestmark = [pytest.mark.ros, pytest.mark.system]
DEADLINE = 600.0
SAY_WHAT_ROBOTS_CALL = """
import json
from scripts.kernels_in_use import in_use, use_all
use_all()
print("called:" + json.dumps(in_use()))
"""


def test_no_robot_calls_what_set_up_has_not_compiled() -> None:
    """In a process of its own: what other tests call does not count."""
    command = [sys.executable, "-c", SAY_WHAT_ROBOTS_CALL]
    done = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, timeout=DEADLINE, check=True
    )
    (line,) = [each for each in done.stdout.splitlines() if each.startswith("called:")]
    called = {json.dumps(entry) for entry in json.loads(line.removeprefix("called:"))}
    listed = {json.dumps(list(entry)) for entry in read_list()}
    assert called
    missing = sorted(called - listed)
    assert not missing, f"run 'python -m scripts.kernels record': {missing}"
