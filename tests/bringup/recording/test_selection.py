"""Claims: patterns fit whole names; hidden topics stay out unless they are of actions."""

from __future__ import annotations

import argparse

import pytest

from bringup.recording.selection import PlayFilter, add_options, selection_of


def chosen(*words: str, hidden: bool = False) -> PlayFilter:
    parser = argparse.ArgumentParser()
    add_options(parser)
    return selection_of(parser.parse_args(words), hidden)


@pytest.mark.parametrize(
    ("words", "topic", "taken"),
    [
        ([], "/scan", True),
        ([], "/x/_hidden", False),
        ([], "/navigate_to_pose/_action/status", True),
        (["--topics", "/scan", "odom"], "/odom", True),
        (["--topics", "/scan"], "/scan_filtered", False),
        (["--topics", "/camera/.*"], "/camera/image_raw", True),
        (["--topics", "/x/_hidden"], "/x/_hidden", True),
        (["--exclude", "/camera/.*"], "/camera/image_raw", False),
        (["--topics", "/camera/.*", "--exclude", ".*/image_raw"], "/camera/image_raw", False),
        (["-e", "/camera/.*", "-x", ".*/image_raw"], "/camera/camera_info", True),
    ],
)
def test_topics_are_chosen(words: list[str], topic: str, taken: bool) -> None:
    assert chosen(*words).takes(topic) == taken


def test_a_bad_expression_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        chosen("--topics", "/a(")
    assert "is no regular expression" in capsys.readouterr().err
