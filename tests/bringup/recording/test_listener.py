"""Claims: gaps in the publishers' numbers are counted, new publishers are not taken for gaps."""

from __future__ import annotations

import pytest

from bringup.recording.listener import LossCounter


@pytest.mark.parametrize(
    ("numbers", "publishers", "lost"),
    [
        ([1, 2, 3], 1, 0),
        ([7, 8, 9], 1, 0),  # joined late
        ([1, 2, 5, 6], 1, 2),
        ([1, 50, 2, 51, 3], 2, 0),  # two publishers
        ([1, 50, 2, 53], 2, 2),
        ([8, 9, 1, 2], 1, 0),  # the publisher began again
        ([8, 9, 1, 2, 4], 1, 1),
    ],
)
def test_gaps_are_counted(numbers: list[int], publishers: int, lost: int) -> None:
    counter = LossCounter()
    for number in numbers:
        counter.take(number, publishers)
    assert counter.lost == lost
