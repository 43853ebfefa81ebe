"""docs/reference/: the pages made from the nodes are current."""

from __future__ import annotations

import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from scripts.reference import FOLDER, parameters, topics

pytestmark = pytest.mark.ros
CURE = "run: python -m scripts.reference"


def test_the_page_of_parameters_is_current() -> None:
    assert (FOLDER / "parameters.md").read_text(encoding="utf-8") == parameters.page(), CURE


def test_the_page_of_topics_is_current() -> None:
    assert (FOLDER / "topics.md").read_text(encoding="utf-8") == topics.page(), CURE
