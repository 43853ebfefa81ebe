"""Shell completion, in a real bash."""

from __future__ import annotations

import shutil
import subprocess

import pytest

from arjuna_core.errors import ArjunaError
from bringup.ros2 import completion

BASH = shutil.which("bash")
pytestmark = pytest.mark.skipif(BASH is None, reason="no bash here")
LIVE = 'ros2() { [ "$*" = "topic list" ] && printf "/scan\\n/odom\\n"; }\n'


def complete(*words: str) -> list[str]:
    """Return what bash offers for the last of the words."""
    quoted = " ".join(f"'{word}'" for word in ("ros2", *words))
    tail = (
        f"\nCOMP_WORDS=({quoted}); COMP_CWORD={len(words)}; _arjuna_ros2;"
        ' printf "%s\\n" "${COMPREPLY[@]}"'
    )
    text = LIVE + completion.script("bash") + tail
    done = subprocess.run([str(BASH), "-c", text], capture_output=True, text=True, check=True)
    assert done.stderr == ""
    return done.stdout.split()


def test_commands_are_completed() -> None:
    assert complete("to") == ["topic"]
    assert {"action", "bag", "doctor", "topic"} <= set(complete(""))


def test_verbs_are_completed() -> None:
    assert complete("topic", "e") == ["echo"]
    assert complete("param", "d") == ["delete", "describe", "dump"]


def test_options_are_completed() -> None:
    assert complete("topic", "echo", "--on") == ["--once"]
    assert "--param-type" in complete("param", "list", "--p")


def test_names_of_the_graph_are_asked_for() -> None:
    assert complete("topic", "echo", "/s") == ["/scan"]


def test_zsh_gets_the_same_script_behind_bashcompinit() -> None:
    first, *rest = completion.script("zsh").splitlines()
    assert "bashcompinit" in first
    assert rest == completion.script("bash").splitlines()


def test_an_unknown_shell_is_refused() -> None:
    with pytest.raises(ArjunaError, match="no completion for 'fish'; valid: bash, zsh"):
        completion.script("fish")
