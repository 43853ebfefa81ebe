"""The base of all nodes that ask a server and wait for its answer.

Source: nav2_behavior_tree, BtActionNode and BtServiceNode.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from arjuna_nav.trees.exchange import Answer
from arjuna_nav.trees.node import Maker, Status, TreeNode
from arjuna_nav.trees.ports import NUMBER, PATH, TEXT, WHOLE, Port

RECOVERIES = "number_recoveries"
"""Entry of the blackboard that counts recoveries, as Nav2's."""


class Asking(TreeNode):
    """Asks a server once, and ends as its answer says; a halt withdraws the request.

    Each port with a `field` fills that field of the request; each output port takes the field of
    the result, or of the feedback, that it names.
    """

    KIND: ClassVar[str]
    SERVER: ClassVar[str] = ""
    NAMED_BY: ClassVar[str]
    """Port of another server's name, which may be empty."""
    FEEDBACK: ClassVar[bool] = False
    """Feedback is written to ports while it runs."""
    RENEWS: ClassVar[tuple[str, ...]] = ()
    """Fields of the request whose change has the server asked again."""
    server_timeout = Port(NUMBER, 0.0)
    _key: int | None = None
    _cancelled = False
    _asked: Mapping[str, Any] = {}
    _writes = 0

    def __init__(self, maker: Maker) -> None:
        super().__init__(maker)
        self.tree.asking.append(self)

    def _tick(self) -> Status:
        if self._key is None:
            self.set_status(Status.RUNNING)
            self._count()
            return self._ask()
        if self._cancelled:
            self._key, self._cancelled = None, False
            return Status.SUCCESS
        answer = self.tree.state.answers.get(self._key)
        if answer is not None:
            self._key = None
            return self._take(answer)
        if self.FEEDBACK:
            self._write(self.tree.state.feedback.get(self._key, {}), True)
        return self._ask() if self.RENEWS and self._is_outdated() else Status.RUNNING

    def _ask(self) -> Status:
        self._asked = self._request()
        timeout = float(self.server_timeout) / 1000.0  # [ms] in XML
        self._key = self.tree.ask(self.KIND, self.server, self._asked, self.FEEDBACK, timeout)
        return Status.RUNNING

    @property
    def server(self) -> str:
        """The name of the server that is asked."""
        return str(self.get(self.NAMED_BY)) or self.SERVER

    @property
    def asked(self) -> Mapping[str, Any]:
        """The fields of the request that runs; none where none runs."""
        return self._asked if self._key is not None else {}

    def _request(self) -> dict[str, Any]:
        """Return what is asked, by the names of the message's fields."""
        values = {
            port.field: self.get(name)
            for name, port in self.PORTS.items()
            if port.field and not port.output
        }
        return {field: value for field, value in values.items() if value is not None}

    def _is_outdated(self) -> bool:
        """Return whether the request has changed; a path is another where it is another array."""
        writes = self.board.writes.count
        if writes == self._writes:
            return False
        self._writes = writes
        ports = ((p.field, n) for n, p in self.PORTS.items() if p.field in self.RENEWS)
        for field, name in ports:
            value, before = self.get(name), self._asked.get(field)
            if value is not before and (self.PORTS[name].kind is PATH or value != before):
                return True
        return False

    def _count(self) -> None:
        """Count a recovery for feedback, unless the XML denies that it is one."""
        if "is_recovery" in self.PORTS and self.get("is_recovery"):
            board = self.tree.blackboard
            board.set(RECOVERIES, (board.get(RECOVERIES) or 0) + 1)

    def cancel(self) -> None:
        """Withdraw the request, as another node wants it; this one succeeds then, as Nav2's."""
        if self._key is not None and not self._cancelled:
            self.tree.withdraw(self._key)
            self._cancelled = True

    def _take(self, answer: Answer) -> Status:
        self._write(answer.values, answer.succeeded)
        return Status.SUCCESS if answer.succeeded else Status.FAILURE

    def _write(self, values: Mapping[str, Any], succeeded: bool) -> None:
        """Write a result to the output ports; a path only where it succeeded."""
        for name, port in self.PORTS.items():
            field = port.field or name
            if port.output and field in values and (succeeded or port.kind is not PATH):
                self.put(name, values[field])

    def _on_halt(self) -> None:
        self.cancel()
        self._key, self._cancelled = None, False


class Action(Asking):
    """Asks an action's server."""

    NAMED_BY = "server_name"
    server_name = Port(TEXT, "")
    error_code_id = Port(WHOLE, 0, output=True)
    error_msg = Port(TEXT, "", output=True)

    def _take(self, answer: Answer) -> Status:
        self.error_code_id = 0 if answer.succeeded else answer.code
        self.error_msg = "" if answer.succeeded else answer.message
        if not answer.succeeded:
            self.tree.note_failure(answer.code, answer.message)
        return super()._take(answer)


class Service(Asking):
    """Asks a service."""

    NAMED_BY = "service_name"
    service_name = Port(TEXT, "")
