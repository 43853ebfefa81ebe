"""The result of checking parameters: values, names without effect and why, and problems."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from enum import Enum
from typing import NamedTuple

from bringup.parameters.files import Parameters


class Kind(Enum):
    """Why a name is reported; the value is the word that the log and `params check` use."""

    UNKNOWN = "unknown"
    UNLIKE = "unlike the robot"
    NO_EFFECT = "no effect yet"
    NOT_NEEDED = "not needed here"


class Remark(NamedTuple):
    """One name without effect, or one whose value is not the robot's.

    Attributes:
        kind: Why.
        where: The node, or the node and the key.
        reason: The nearest valid name, what Nav2 would do, or why nothing is missed.
        safety: Whether the name keeps a robot from harm elsewhere.
        location: File and line; empty where not known.
    """

    kind: Kind
    where: str
    reason: str
    safety: bool = False
    location: str = ""

    def __str__(self) -> str:
        word = f"{self.kind.value}{' (SAFETY)' if self.safety else ''}"
        location = f"{self.location}: " if self.location else ""
        return f"{location}{word}: {self.where}: {self.reason}"


class Checked(NamedTuple):
    """Parameters with those of a source over them.

    Attributes:
        problems: What refuses the source, a sentence each.
    """

    parameters: Parameters
    remarks: list[Remark]
    problems: list[str]

    def refused_by(self, strict: bool) -> list[str]:
        """Return what refuses the source; where it is strict, unknown names too."""
        unknown = [str(one) for one in self.remarks if one.kind is Kind.UNKNOWN]
        return [*self.problems, *(unknown if strict else ())]


def lines(
    remarks: Iterable[Remark], counted: Collection[Kind] = (), where: str = "'params check FILE'"
) -> Iterator[str]:
    """Return a log's lines: what keeps a robot from harm first, then what is unknown, then others.

    Keys of one node with one reason share a line, but for those of safety.

    Args:
        counted: The kinds of which a count stands for the lines, but for those of safety.
        where: What lists them.
    """
    ordered = sorted(remarks, key=lambda one: (not one.safety, list(Kind).index(one.kind)))
    grouped: dict[tuple[str, ...], list[Remark]] = {}
    for one in ordered:
        node, _, key = one.where.partition(": ")
        own = one.where + one.location if one.safety or not key else ""
        grouped.setdefault((one.kind.value, node, one.reason, own), []).append(one)
    for (_, node, *_), group in grouped.items():
        if group[0].safety or group[0].kind not in counted:
            keys = ", ".join(one.where.partition(": ")[2] for one in group)
            yield str(group[0]._replace(where=f"{node}: {keys}" if keys else node))
    for kind in counted:
        if count := sum(one.kind is kind and not one.safety for one in ordered):
            yield f"{kind.value}: {count} names; {where} lists them"
