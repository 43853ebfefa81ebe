"""What a check finds."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """Something that is wrong.

    Attributes:
        what: What is wrong, with the numbers.
        cure: What to do about it.
    """

    what: str
    cure: str

    def __str__(self) -> str:
        return f"{self.what}: {self.cure}"
