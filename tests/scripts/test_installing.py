"""Who installs the packages."""

from __future__ import annotations

from pathlib import Path

import pytest

from scripts import installing
from scripts.steps import StepError


def program(path: Path, code: int) -> Path:
    """Write a program that notes its arguments and ends with a code."""
    path.write_text(f'#!/bin/sh\necho "$@" >> {path}.calls\nexit {code}\n')
    path.chmod(0o755)
    return path


def calls(path: Path) -> str:
    """Return the arguments of a program's calls."""
    file = path.with_name(f"{path.name}.calls")
    return file.read_text() if file.exists() else ""


def test_uv_installs_where_it_is(tmp_path: Path) -> None:
    uv, python = program(tmp_path / "uv", 0), program(tmp_path / "python", 0)
    installing.install("packages", tmp_path / "log", python, uv, ["-r", "x.txt"])
    assert calls(uv) == f"pip install --no-deps --python {python} -r x.txt\n"
    assert calls(python) == ""


def test_pip_installs_where_uv_cannot(tmp_path: Path) -> None:
    uv, python = program(tmp_path / "uv", 2), program(tmp_path / "python", 0)
    installing.install("packages", tmp_path / "log", python, uv, ["-r", "x.txt"])
    assert calls(python) == "-m pip install --no-deps --no-compile -r x.txt\n"


def test_what_pip_cannot_install_fails(tmp_path: Path) -> None:
    python = program(tmp_path / "python", 1)
    with pytest.raises(StepError, match="packages failed; the whole log is"):
        installing.install("packages", tmp_path / "log", python, None, [])


def test_uv_is_installed_once_a_version(tmp_path: Path) -> None:
    lock, folder, log = tmp_path / "lock", tmp_path / "tool", tmp_path / "log"
    python = tmp_path / "python"
    python.write_text(
        f"#!/bin/sh\necho x >> {python}.calls\nmkdir -p {folder}/bin\ntouch {folder}/bin/uv\n"
    )
    python.chmod(0o755)
    for version, runs in (("1", 1), ("1", 1), ("2", 2)):
        lock.write_text(f"numpy==3\nuv=={version}  # setup\n")
        assert installing.find_uv(lock, python, folder, log) == folder / "bin" / "uv"
        assert calls(python).count("x") == runs


def test_without_uv_in_the_index_pip_is_left(tmp_path: Path) -> None:
    lock, python = tmp_path / "lock", program(tmp_path / "python", 1)
    lock.write_text("uv==1  # setup\n")
    assert installing.find_uv(lock, python, tmp_path / "tool", tmp_path / "log") is None
