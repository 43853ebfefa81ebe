"""The generators' templates expand to the same text when each is scanned once."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("em", reason="no EmPy here")

FOLDER = Path(__file__).resolve().parents[2] / "arjuna_interfaces"
TEMPLATE = """@# a comment
@{
names = sorted(words)
seen = set()
}@
@[for name in names]@
@[  if name in seen]@
again @(name)
@[  elif len(name) > 3]@
@{seen.add(name[:3])}@
long @( name ) costs @(len(name) * 2) @@ each
@[  else]@
short @(name.upper() + "}")
@[  end if]@
@[end for]@
end of @(names)"""
COMPARE = """
import io, sys
import em
sys.path.insert(0, sys.argv[1])
from rosidl_build.templates import remember_scans

def expanded(words):
    output = io.StringIO()
    config = em.Configuration(
        defaultStdout=output, deleteOnError=True, rawErrors=True, useProxy=True
    )
    interpreter = em.Interpreter(config=config, dispatcher=False)
    interpreter.string(sys.argv[2], locals={"words": words})
    interpreter.shutdown()
    return output.getvalue()

inputs = [["pose", "map"], ["a"], [], ["goal", "goa", "path"]]
before = [expanded(words) for words in inputs]
assert "long goal costs 8 @ each" in before[3] and "short GOA}" in before[3], before[3]
remember_scans()
assert [expanded(words) for words in inputs] == before
em.Scanner.one = None  # what was scanned is not scanned again
assert [expanded(words) for words in inputs] == before
print("same")
"""


def test_a_template_that_is_scanned_once_expands_as_before() -> None:
    command = [sys.executable, "-c", COMPARE, str(FOLDER), TEMPLATE]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout) == (0, "same\n"), done.stderr
