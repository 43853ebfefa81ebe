"""Kernels compiled once, and containers."""

from __future__ import annotations

import importlib
import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
from numba.core import types

from arjuna_nav.costmap.moving.sightings import Sightings
from scripts import kernels, preflight
from scripts.kernels_in_use import decode, encode

pytest.importorskip("numba", reason="no Numba here")


TYPES = (
    types.float64,
    types.int64,
    types.boolean,
    types.none,
    types.literal(3),
    types.Array(types.uint8, 2, "C"),
    types.Array(types.float32, 3, "A", readonly=True),
    types.Array(types.boolean, 1, "F"),
    types.UniTuple(types.int64, 2),
    types.Tuple((types.none, types.Array(types.int32, 1, "C"))),
    types.NamedTuple([types.Array(types.float64, 1, "C")] + 5 * [types.int64], Sightings),
    types.NamedUniTuple(types.int64, 6, Sightings),
)


@pytest.mark.parametrize("kind", TYPES, ids=str)
def test_a_type_survives_the_list(kind: Any) -> None:
    assert decode(json.loads(json.dumps(encode(kind)))) == kind


def test_a_type_that_the_list_cannot_hold_is_refused() -> None:
    with pytest.raises(TypeError, match="no encoding for unicode_type"):
        encode(types.unicode_type)


def test_the_list_names_functions_that_are_there() -> None:
    entries = kernels.read_list()
    assert len(entries) > 30
    for module, name, arguments in entries:
        function = getattr(importlib.import_module(module), name)
        assert len(arguments) <= function.py_func.__code__.co_argcount, (module, name)
        assert [encode(decode(each)) for each in arguments] == arguments


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """Four modules: `plan` calls `walk`, which takes `FREE` from `grid`; `other` has its own."""
    folder = tmp_path / "arjuna_nav"
    (folder / "__pycache__").mkdir(parents=True)
    (folder / "plan.py").write_text(
        "from numba import njit\n"
        "from arjuna_nav import walk as w\nfrom arjuna_nav.walk import (\n    walk,\n)\n"
    )
    (folder / "walk.py").write_text("from numba import njit\nfrom arjuna_nav.grid import FREE\n")
    (folder / "grid.py").write_text("from arjuna_nav.words import NAME\nFREE = 0\n")
    (folder / "words.py").write_text("NAME = 'grid'\n")
    (folder / "other.py").write_text("from numba import njit\n")
    for name in ("plan", "walk", "other"):
        (folder / "__pycache__" / f"{name}.run-3.py311.1.nbc").touch()
        (folder / "__pycache__" / f"{name}.run-3.py311.nbi").touch()
    return folder


def compiled(tree: Path) -> set[str]:
    """Return the modules of which something compiled is left."""
    return {path.name.partition(".")[0] for path in tree.glob("__pycache__/*.nb[ic]")}


@pytest.mark.parametrize(
    ("changed", "left"),
    [
        (None, {"plan", "walk", "other"}),
        ("other", {"plan", "walk"}),
        ("plan", {"walk", "other"}),
        ("walk", {"other"}),
        ("grid", {"other"}),
        ("words", {"plan", "walk", "other"}),
    ],
)
def test_a_change_deletes_its_kernels(changed: str | None, left: set[str], tree: Path) -> None:
    state = tree.parent / ".setup" / "kernels.json"
    kernels.forget_stale(tree.parent, state)
    assert compiled(tree) == {"plan", "walk", "other"}
    if changed is not None:
        with (tree / f"{changed}.py").open("a") as file:
            file.write("FREE = 1\n")
    kernels.forget_stale(tree.parent, state)
    assert compiled(tree) == left
    assert kernels.digests(tree.parent).keys() == {
        f"arjuna_nav.{name}" for name in ("plan", "walk", "other")
    }


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


def test_the_last_stage_of_a_container_has_no_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
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
