"""The robot that the tests of navigation play, made as each module says, and closed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from tests.helpers.nav.navigation import PlayedRobot


@pytest.fixture
def robot(request: pytest.FixtureRequest) -> PlayedRobot:
    """The robot that the module's `made()` returns, else one with all of navigation."""
    from tests.helpers.nav import navigator_goals

    made: Callable[[], PlayedRobot] = getattr(request.module, "made", navigator_goals.made)
    return made()


@pytest.fixture(autouse=True)
def _robots_are_closed() -> Iterator[None]:
    from tests.helpers.nav.navigation import PlayedRobot

    yield
    for robot in list(PlayedRobot.open):
        robot.close()
