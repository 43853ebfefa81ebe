"""Messages that never arrived, found by the gaps in their publishers' numbers."""

from __future__ import annotations


class LossCounter:
    """Counts what is missing on one topic.

    A publisher numbers its messages; who published one is not told, so with several publishers
    a message belongs to the one whose number it continues.

    Attributes:
        lost: How many messages were published and did not arrive.
    """

    def __init__(self) -> None:
        self.lost = 0
        self._last: list[int] = []

    def take(self, number: int, publishers: int) -> None:
        """Note a message.

        Args:
            number: The publisher's number of it.
            publishers: How many publishers the topic has now.
        """
        for place, last in enumerate(self._last):
            if number == last + 1:
                self._last[place] = number
                return
        before = [last for last in self._last if last < number]
        if len(self._last) < publishers or not before:
            self._last.append(number)  # a publisher that is new, or that began again
            del self._last[: -max(publishers, 1)]
            return
        self.lost += number - max(before) - 1
        self._last[self._last.index(max(before))] = number
