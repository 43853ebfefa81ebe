"""How often the robot ran into what."""

from __future__ import annotations


class ContactLog:
    """Counts contacts by name: one begins when the robot touches what it did not touch before."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget all."""
        self.touched: tuple[str, ...] = ()
        self.counts: dict[str, int] = {}

    def update(self, touched: tuple[str, ...]) -> bool:
        """Take the names of what the robot touches now; tell whether they have changed."""
        if touched == self.touched:
            return False
        for name in touched:
            if name not in self.touched:
                self.counts[name] = self.counts.get(name, 0) + 1
        self.touched = touched
        return True

    @property
    def total(self) -> int:
        """How many contacts have begun."""
        return sum(self.counts.values())
