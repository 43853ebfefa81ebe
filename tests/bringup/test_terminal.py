"""Claims: a key is one press, an arrow too, though a terminal sends three bytes of it."""

from __future__ import annotations

import os

import pytest

from bringup.terminal import RIGHT, UP, Keys


def test_arrows_and_escape_are_keys(monkeypatch: pytest.MonkeyPatch) -> None:
    ours, theirs = os.openpty()
    with open(theirs) as terminal:  # noqa: PTH123 - a descriptor
        monkeypatch.setattr("sys.stdin", terminal)
        with Keys() as keys:
            assert keys.live
            os.write(ours, f"a{UP}{RIGHT} \x1b".encode())
            assert [keys.wait(5.0) for _ in range(5)] == ["a", UP, RIGHT, " ", "\x1b"]
            assert keys.wait(0.0) == ""
    os.close(ours)
