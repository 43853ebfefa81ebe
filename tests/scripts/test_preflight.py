"""Checks before the set-up, and packages that it names."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any

import pytest

from scripts import installing, preflight
from scripts.installing import EXTRAS, INSTALLER, ON_REQUEST, lines_of, wanted_extras
from scripts.preflight import Missing, explain, find_missing
from scripts.setup_env import LOCK
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


@pytest.mark.parametrize(
    ("code", "of_pip"), [(0, ""), (2, "-m pip install --no-deps --no-compile -r x.txt\n")]
)
def test_uv_installs_or_else_pip(tmp_path: Path, code: int, of_pip: str) -> None:
    uv, python = program(tmp_path / "uv", code), program(tmp_path / "python", 0)
    installing.install("packages", tmp_path / "log", python, uv, ["-r", "x.txt"])
    assert calls(uv) == f"pip install --no-deps --python {python} -r x.txt\n"
    assert calls(python) == of_pip


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


def test_comments_name_the_extras_of_a_line(tmp_path: Path) -> None:
    lock = tmp_path / "requirements.lock"
    lock.write_text(
        "# A header.\nnumpy==1 ; python_version < '3.11'\npyarrow==2  # campaign view\n"
        "rerun-sdk==3 ; python_version >= '3.11'  # view\n"
    )
    assert lines_of(lock) == ["numpy==1 ; python_version < '3.11'"]
    assert lines_of(lock, "campaign") == ["pyarrow==2"]
    assert lines_of(lock, "view") == ["pyarrow==2", "rerun-sdk==3 ; python_version >= '3.11'"]


def test_our_lock_file_has_no_other_extras() -> None:
    named = re.findall(r"  # ([a-z ]+)$", LOCK.read_text(), re.MULTILINE)
    known = *EXTRAS, *ON_REQUEST
    assert {word for words in named for word in words.split()} == {*known, INSTALLER}
    assert all(lines_of(LOCK, extra) for extra in known)
    assert len(lines_of(LOCK, INSTALLER)) == 1


@pytest.mark.parametrize(
    ("value", "wanted"),
    [
        (None, EXTRAS),
        ("all", EXTRAS),
        ("all cluster", tuple(sorted((*EXTRAS, "cluster")))),
        ("", ()),
        ("view", ("view",)),
        ("view,tune", ("tune", "view")),
    ],
)
def test_extras_are_all_unless_they_are_named(
    value: str | None, wanted: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("EXTRAS", raising=False)
    if value is not None:
        monkeypatch.setenv("EXTRAS", value)
    assert wanted_extras() == wanted


def test_an_unknown_extra_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("EXTRAS", "view rviz")
    with pytest.raises(
        StepError, match="EXTRAS has no rviz; valid: campaign, dev, gpu, learn, tune, view, cluster"
    ):
        wanted_extras()


def test_all_that_is_missing_is_named_at_once_with_one_command_for_all() -> None:
    missing = [Missing("venv", ("python3.11-venv",)), Missing("gcc", ("gcc", "libc6-dev"))]
    assert explain(missing) == [
        "error: missing venv; sudo apt-get install -y python3.11-venv",
        "error: missing gcc; sudo apt-get install -y gcc libc6-dev",
        "all at once: sudo apt-get install -y python3.11-venv gcc libc6-dev",
    ]
    assert explain([Missing("disk", advice="free some")]) == ["error: missing disk; free some"]


def test_no_gl_is_a_warning_only(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ctypes.util.find_library", lambda name: None)
    (missing,) = find_missing((preflight.check_gl,))
    assert not missing.fatal
    assert explain([missing])[0].startswith("warning: no libEGL")


@pytest.mark.parametrize(
    ("version", "fits"), [((3, 9), False), ((3, 10), True), ((3, 13), True), ((3, 14), False)]
)
def test_python_versions_without_compiled_packages_are_refused(
    version: tuple[int, int], fits: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.version_info", (*version, 0, "final", 0))
    assert (preflight.check_python() is None) == fits


def test_what_a_python_lacks_is_in_debians_packages(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "importlib.util.find_spec", lambda name: None if name == "ensurepip" else object()
    )
    monkeypatch.setattr("sysconfig.get_path", lambda name: str(tmp_path))
    missing = find_missing((preflight.check_venv, preflight.check_headers))
    assert [re.sub(".*-", "", one.packages[0]) for one in missing] == ["venv", "dev"]


@pytest.mark.parametrize("command", ["no-such-compiler", "false", ""])
def test_a_broken_compiler_is_missing(command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", command)
    monkeypatch.setenv("CXX", command)
    assert preflight.check_c() is not None
    assert preflight.check_cxx() is not None


def test_a_full_disk_is_found_before_it_is_filled(monkeypatch: pytest.MonkeyPatch) -> None:
    class Usage:
        free = 2**30

    def usage(path: Any) -> Usage:
        return Usage()

    monkeypatch.setattr(shutil, "disk_usage", usage)
    missing = preflight.check_disk()
    assert missing is not None
    assert "1.0 GiB are free" in missing.what
