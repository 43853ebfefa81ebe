"""A section's commands run in order, beside each other where they stay, and all are ended."""

from __future__ import annotations

from pathlib import Path

import pytest

from bringup.lessons.runner import LessonError, Section, load_page, program, run_section

SERVER = """
import signal, sys
print("serving", flush=True)
def end(number, frame):
    print("server ended", flush=True)
    sys.exit(0)
signal.signal(signal.SIGINT, end)
signal.pause()
"""


def _section(folder: Path, *lines: str, promises: str = "") -> Section:
    (folder / "server.py").write_text(SERVER, encoding="utf-8")
    (folder / "hello.py").write_text("import sys; print('hello', *sys.argv[1:])", encoding="utf-8")
    (folder / "fail.py").write_text("raise SystemExit(3)", encoding="utf-8")
    (folder / "mute.py").write_text("", encoding="utf-8")
    page = folder / "page.md"
    commands = "\n".join(lines)
    page.write_text(f"## A\n```sh\n{commands}\n```\n```text\n{promises}\n```\n", encoding="utf-8")
    return load_page(page).sections[0]


def _run(section: Section, folder: Path) -> tuple[list[str], str]:
    shown: list[str] = []
    problems = run_section(section, folder, shown.append, attended=False)
    return problems, "".join(shown)


def test_what_stays_runs_beside_the_rest_and_is_ended(tmp_path: Path) -> None:
    lines = ("python server.py &", "python hello.py there")
    section = _section(tmp_path, *lines, promises="serving\nhello there\nserver ended")
    problems, shown = _run(section, tmp_path)
    assert problems == []
    assert shown.index("serving") < shown.index("hello there")
    assert "server ended" not in shown  # what stays is quiet once it is up


def test_what_is_watched_is_ended_by_an_interrupt(tmp_path: Path) -> None:
    section = _section(tmp_path, "python server.py  # Ctrl-C after 1 s", promises="server ended")
    assert _run(section, tmp_path)[0] == []


def test_broken_promises_and_failures_are_reported(tmp_path: Path) -> None:
    section = _section(tmp_path, "python hello.py", "python fail.py", promises="hello world")
    assert _run(section, tmp_path)[0] == ["'python fail.py' failed", "not printed: hello world"]


def test_what_needs_hands_is_left_out_where_nobody_is(tmp_path: Path) -> None:
    section = _section(tmp_path, "python fail.py  # by hand", "python hello.py", promises="hello")
    assert _run(section, tmp_path)[0] == []


def test_what_ends_instead_of_coming_up_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(LessonError, match=r"'python mute\.py &' is not up"):
        _run(_section(tmp_path, "python mute.py &", promises="x"), tmp_path)


def test_other_programs_are_not_run() -> None:
    with pytest.raises(LessonError, match=r"'rm -r x' is not run; valid: python \.\.\., ros2"):
        program(("rm", "-r", "x"))
