"""The tutorial's pages: what they name is there, and every command of theirs is a command."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from bringup.cli_parser import parse
from bringup.commands import COMMANDS as COMMANDS_OF_OURS
from bringup.commands.lesson import PAGES
from bringup.lessons.page import Command, load_page
from bringup.ros2.grammar import build_parser
from bringup.ros2.tables import COMMANDS

ROOT = Path(__file__).resolve().parents[3]
TUTORIAL = ROOT / "docs" / "tutorial"
EACH = pytest.mark.parametrize("name", PAGES.values())
FILES = re.compile(r"[\w./-]+\.(?:yaml|urdf|xacro|world|py)")
INLINE = re.compile(r"(?<!`)`([^`\n]+)`(?!`)")
ALL = {name for group in COMMANDS_OF_OURS.values() for name in group}
RUN = {("tf2_ros", "tf2_echo"), ("nav2_map_server", "map_saver_cli")}
"""What `ros2 run` is used for; its programs are listed in docs/ros2.md."""
LINKS = re.compile(r"\]\(([^)#]+?)\)")


def _commands(name: str) -> list[Command]:
    page = load_page(TUTORIAL / f"{name}.md")
    return [command for section in page.sections for command in section.commands]


@EACH
def test_every_command_is_understood(name: str) -> None:
    for command in _commands(name):
        program, *words = command.words
        if words[:2] == ["-m", "bringup"]:
            assert parse(words[2:]).run is not None, command.text
        elif words[0] == "run":
            assert tuple(words[1:3]) in RUN, command.text
        elif program == "ros2":
            assert build_parser(COMMANDS).parse_args(words) is not None, command.text
        else:
            assert (program, Path(words[0]).suffix) == ("python", ".py"), command.text


@EACH
def test_what_its_words_propose_is_understood(name: str) -> None:
    """Commands in running text; where a word in capitals stands for something, only the name."""
    for text in INLINE.findall((TUTORIAL / f"{name}.md").read_text(encoding="utf-8")):
        words = shlex.split(text.removeprefix("python -m bringup "))
        if words[0] in ALL and len(words) > 1 and not any(word.isupper() for word in words):
            assert parse(words).command == words[0], text


@EACH
def test_every_file_it_names_is_there(name: str) -> None:
    for command in _commands(name):
        for word in FILES.findall(command.text):
            assert word.startswith("out/") or (ROOT / word).is_file(), word


@EACH
def test_every_section_promises_something(name: str) -> None:
    for section in load_page(TUTORIAL / f"{name}.md").sections:
        assert section.promises, section.title
        assert section.missing("")


@pytest.mark.parametrize(
    "path",
    sorted(
        {*(ROOT / "docs").rglob("*.md"), ROOT / "README.md", *ROOT.glob("[bcgmpuw]*/README.md")}
    ),
    ids=lambda path: str(path.relative_to(ROOT)),
)
def test_its_links_and_pictures_are_there(path: Path) -> None:
    for target in LINKS.findall(path.read_text(encoding="utf-8")):
        assert target.startswith("http") or (path.parent / target).exists(), target
