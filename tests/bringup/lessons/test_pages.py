"""Lessons' pages: parts, links and pictures."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from arjuna_core.errors import InputFileError
from bringup.cli import parse
from bringup.commands import COMMANDS
from bringup.commands.lesson import PAGES
from bringup.lessons.runner import Command, load_page
from bringup.ros2.grammar import build_parser

PAGE = """# A lesson

Words before the first heading.

## First

What you will see.

```sh
python -m bringup sim --world "a b.world" &
python -m bringup teleop    # by hand
ros2 topic hz /scan   # Ctrl-C after 5 s
```
```text
average rate: 10...
done  (all)
```
Words after.

## Nothing to type

```
a block without a language is not run
```
"""


def _page(folder: Path, text: str = PAGE) -> Path:
    path = folder / "page.md"
    path.write_text(text, encoding="utf-8")
    return path


def test_sections_with_commands_are_found(tmp_path: Path) -> None:
    page = load_page(_page(tmp_path))
    (section,) = page.sections
    assert (page.title, section.title, section.text) == ("A lesson", "First", "What you will see.")
    assert section.promises == ("average rate: 10...", "done  (all)")


def test_a_command_says_whether_it_stays_ends_or_needs_hands(tmp_path: Path) -> None:
    stays, by_hand, watched = load_page(_page(tmp_path)).sections[0].commands
    assert stays.words == ("python", "-m", "bringup", "sim", "--world", "a b.world")
    assert (stays.stays, by_hand.by_hand, watched.seconds) == (True, True, 5.0)
    assert isinstance(watched, Command)
    assert watched.words == ("ros2", "topic", "hz", "/scan")
    assert not watched.stays
    assert by_hand.seconds is None


@pytest.mark.parametrize(
    ("printed", "missing"),
    [
        ("average rate: 10.004\n  done (all)\n", []),
        ("average  rate:\t10\ndone (all)", []),
        ("average rate: 9.9\ndone (all)", ["average rate: 10..."]),
        ("average rate: 10\ndone all", ["done  (all)"]),
        ("average rate:\ndone (all)\n10", ["average rate: 10..."]),
    ],
)
def test_a_promise_is_kept_by_its_line(tmp_path: Path, printed: str, missing: list[str]) -> None:
    assert load_page(_page(tmp_path)).sections[0].missing(printed) == missing


def test_of_four_dots_the_first_is_the_numbers_own(tmp_path: Path) -> None:
    text = PAGE.replace("average rate: 10...\n", "error: 0....m\n").replace("done  (all)\n", "")
    (section,) = load_page(_page(tmp_path, text)).sections
    assert section.missing("error: 0.20m") == []
    assert section.missing("error: 10 m") == ["error: 0....m"]


@pytest.mark.parametrize(
    ("text", "problem"), [("# A\n\n## B\n\nwords\n", "holds no command"), (None, "cannot be read")]
)
def test_a_page_without_commands_is_refused(tmp_path: Path, text: str | None, problem: str) -> None:
    path = tmp_path / "none.md" if text is None else _page(tmp_path, text)
    with pytest.raises(InputFileError, match=problem):
        load_page(path)


ROOT = Path(__file__).resolve().parents[3]
TUTORIAL = ROOT / "docs" / "tutorial"
EACH = pytest.mark.parametrize("name", PAGES.values())
FILES = re.compile(r"[\w./-]+\.(?:yaml|urdf|xacro|world|py)")
INLINE = re.compile(r"(?<!`)`([^`\n]+)`(?!`)")
ALL = {name for group in COMMANDS.values() for name in group}
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
            assert build_parser().parse_args(words) is not None, command.text
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


def test_links_and_pictures_of_the_documentation_are_there() -> None:
    pages = {*(ROOT / "docs").rglob("*.md"), *ROOT.glob("[bcgmpuw]*/README.md")}
    for path in sorted({*pages, ROOT / "README.md"}):
        for target in LINKS.findall(path.read_text(encoding="utf-8")):
            assert target.startswith("http") or (path.parent / target).exists(), (path, target)
