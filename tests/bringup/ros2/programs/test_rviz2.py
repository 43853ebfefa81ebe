"""`rviz2`: what it is asked for is what the view is."""

from __future__ import annotations

import pytest

from bringup.ros2.programs import rviz2


@pytest.mark.parametrize(
    ("given", "options"),
    [
        ([], []),
        (["-d", "nav2.rviz"], ["--config", "nav2.rviz"]),
        (["--display-config", "a.rviz", "-f", "odom"], ["--config", "a.rviz", "--frame", "odom"]),
        (["-d", "a.rviz", "-s", "none", "--ros-args", "-r", "__node:=r"], ["--config", "a.rviz"]),
    ],
)
def test_its_options_are_the_view_s(
    given: list[str], options: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    started: list[object] = []
    monkeypatch.setattr(rviz2, "arjuna", lambda command, words: started.append((command, words)))
    rviz2.main(given)
    assert started == [("view", options)]
