"""A page's commands and promises are read as a student reads them."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.errors import InputFileError
from bringup.lessons.page import Command, load_page

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
