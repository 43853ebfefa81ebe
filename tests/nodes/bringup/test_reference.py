"""docs/reference/: the pages made from the nodes are current."""

from __future__ import annotations

from scripts.reference import FOLDER, parameters, topics

REMEDY = "run: python -m scripts.reference"


def test_the_page_of_parameters_is_current() -> None:
    assert (FOLDER / "parameters.md").read_text(encoding="utf-8") == parameters.page(), REMEDY


def test_the_page_of_topics_is_current() -> None:
    assert (FOLDER / "topics.md").read_text(encoding="utf-8") == topics.page(), REMEDY
