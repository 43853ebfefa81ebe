"""The site: pages gathered with all they link, each in its menu, each command one there is."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

from bringup.cli import parse
from scripts.docs_site import START, gather
from scripts.setup_env import ROOT
from tests.helpers.files import write_all

PAGES = sorted((ROOT / "docs").glob("*.md"))
TYPED = re.compile(r"^python -m bringup (.+?)(?:\s+#.*)?$", re.MULTILINE)


def _paths(menu: Any) -> Iterator[str]:
    """Return the pages that a menu names."""
    if isinstance(menu, str):
        yield menu
    else:
        for item in menu.values() if isinstance(menu, dict) else menu:
            yield from _paths(item)


def test_the_menu_names_every_page_and_none_that_is_not_there() -> None:
    menu = set(_paths(yaml.safe_load((ROOT / "mkdocs.yml").read_text(encoding="utf-8"))["nav"]))
    assert [name for name in menu if not (ROOT / name).is_file()] == []
    first = {path.relative_to(ROOT) for pattern in START for path in ROOT.glob(pattern)}
    assert {str(path) for path in first} <= menu


def test_what_is_linked_comes_along_and_nothing_else(tmp_path: Path) -> None:
    root, target = tmp_path / "root", tmp_path / "target"
    pages = {
        "docs/a.md": "[b](../more/b.md#top) ![p](p.png) [w](https://x.y/z.md) [no](none.md)",
        "docs/p.png": "",
        "more/b.md": "[back](../docs/a.md) [code](c.py) [out](../../secret.txt)",
        "more/c.py": "# [d](d.md)",
        "more/d.md": "",
    }
    write_all(root, pages)
    write_all(tmp_path, {"secret.txt": "", "target/old.md": ""})
    gather(root, target, ["docs/*.md"])
    found = {str(path.relative_to(target)) for path in target.rglob("*") if path.is_file()}
    assert found == {"docs/a.md", "docs/p.png", "more/b.md", "more/c.py"}


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_every_command_of_a_page_is_understood(path: Path) -> None:
    text = path.read_text(encoding="utf-8").replace("\\\n", " ")
    for line in TYPED.findall(text):
        if "|" not in line and "[" not in line:  # which stand for a choice of words
            assert parse(shlex.split(line)).run is not None, line
