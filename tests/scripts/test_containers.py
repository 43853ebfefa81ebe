"""The container's files name what there is; hadolint reads them too, where it is installed."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from scripts import preflight

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "Dockerfile").read_text(encoding="utf-8")
LINES = [
    line for line in re.sub(r"\\\n\s*", "", TEXT).splitlines() if line and not line.startswith("#")
]
STAGES = {line.split()[3]: line.split()[1] for line in LINES if re.match(r"FROM \S+ AS ", line)}
PACKAGES = [set(line.split()) for line in LINES if "apt-get install" in line]


def test_each_line_is_an_instruction_and_each_stage_has_an_image_of_one_version() -> None:
    words = {line.split()[0] for line in LINES}
    assert words <= {"FROM", "RUN", "COPY", "WORKDIR", "USER", "ENTRYPOINT", "CMD"}
    for line in LINES:
        if line.startswith("FROM "):
            assert line.split()[1] in STAGES or re.match(r"FROM \w+:3\.1[0-3]-", line), line
        if copied := re.match(r"COPY --from=(\w+) ", line):
            assert copied[1] in STAGES


def test_a_checkout_s_stage_has_what_the_set_up_asks_for_and_the_last_one_no_compiler(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(preflight, "_compiles", lambda *words: False)
    monkeypatch.setattr("ctypes.util.find_library", lambda name: None)
    checks = (preflight.check_c, preflight.check_cxx, preflight.check_gl)
    needed = {name for missing in preflight.find_missing(checks) for name in missing.packages}
    tools, last = PACKAGES
    assert needed | {"make"} <= tools
    assert not {"gcc", "g++", "make"} & last
    assert {"libegl1", "libgl1-mesa-dri"} <= last


def test_the_image_runs_the_wheel_of_this_version_as_no_root() -> None:
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    (version,) = re.findall(r'^version = "(.+)"$', project, re.MULTILINE)
    wheel = f"/wheels/arjuna-{version}-py3-none-any.whl[ros]"
    assert any(line.startswith("RUN pip install") and f'"{wheel}"' in line for line in LINES)
    assert [line for line in LINES if line.startswith("USER ")][-1] == "USER 1000"
    (entry,) = (line for line in LINES if line.startswith("ENTRYPOINT "))
    assert f'\n{json.loads(entry.partition(" ")[2])[0]} = "bringup.' in project
    assert (ROOT / ".dockerignore").read_text().splitlines()[:3] == [".git", ".venv", ".setup"]


def test_the_devcontainer_is_a_stage_and_its_command_a_target() -> None:
    folder = ROOT / ".devcontainer"
    container = json.loads((folder / "devcontainer.json").read_text(encoding="utf-8"))
    build = container["build"]
    assert (folder / build["dockerfile"]).resolve() == ROOT / "Dockerfile"
    assert (folder / build["context"]).resolve() == ROOT
    assert build["target"] in STAGES
    command, target, *_ = container["postCreateCommand"].split()
    assert command == "make"
    assert re.search(rf"^{target}:", (ROOT / "Makefile").read_text(), re.MULTILINE)


@pytest.mark.skipif(shutil.which("hadolint") is None, reason="no hadolint here")
def test_hadolint_finds_nothing() -> None:
    found = subprocess.run(["hadolint", ROOT / "Dockerfile"], capture_output=True, text=True)
    assert (found.returncode, found.stdout) == (0, "")
