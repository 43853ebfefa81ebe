"""The tutorial, run: each section's commands do what the page promises. Slow: `-m tutorial`."""

from __future__ import annotations

import pytest

from arjuna_core.files.shipped import shipped_file
from bringup.commands.lesson import PAGES
from bringup.lessons.runner import Section, load_page, run_section

pytestmark = [pytest.mark.ros, pytest.mark.system, pytest.mark.tutorial]
ROOT = shipped_file("docs").parent
SECTIONS = [
    pytest.param(section, id=f"{name}-{number}")
    for name in PAGES.values()
    for number, section in enumerate(
        load_page(shipped_file(f"docs/tutorial/{name}.md")).sections, 1
    )
]


@pytest.mark.timeout(600)
@pytest.mark.parametrize("section", SECTIONS)
def test_a_section_shows_its_promise(section: Section, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "93")
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    printed: list[str] = []
    problems = run_section(section, ROOT, printed.append, attended=False)
    assert problems == [], "".join(printed)
