"""The parts that the set-up reports as missing."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

from scripts import preflight
from scripts.preflight import Missing, explain, find_missing


def test_all_that_is_missing_is_named_at_once_with_one_command_for_all() -> None:
    missing = [Missing("venv", ("python3.11-venv",)), Missing("gcc", ("gcc", "libc6-dev"))]
    assert explain(missing) == [
        "error: missing venv; sudo apt-get install -y python3.11-venv",
        "error: missing gcc; sudo apt-get install -y gcc libc6-dev",
        "all at once: sudo apt-get install -y python3.11-venv gcc libc6-dev",
    ]


def test_what_no_package_mends_comes_with_advice() -> None:
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


def test_a_python_without_ensurepip_names_debians_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "importlib.util.find_spec", lambda name: None if name == "ensurepip" else object()
    )
    missing = preflight.check_venv()
    assert missing is not None
    assert missing.packages[0].endswith("-venv")


def test_python_without_headers_names_debians_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sysconfig.get_path", lambda name: str(tmp_path))
    missing = preflight.check_headers()
    assert missing is not None
    assert missing.packages[0].endswith("-dev")


@pytest.mark.parametrize("command", ["no-such-compiler", "false", ""])
def test_a_compiler_that_is_absent_or_broken_is_missing(
    command: str, monkeypatch: pytest.MonkeyPatch
) -> None:
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
