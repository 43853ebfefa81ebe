"""What every node is that asks a server and waits for its answer.

Source: nav2_behavior_tree, BtActionNode, BtServiceNode and BtCancelActionNode.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from arjuna_nav.trees.exchange import Answer, Withdraw
from arjuna_nav.trees.node import Maker, Status, TreeNode
from arjuna_nav.trees.ports import NUMBER, TEXT, WHOLE, Port

RECOVERIES = "number_recoveries"
"""Entry of the blackboard that counts recoveries, as Nav2's."""
SERVER_PORTS = {
    "server_name": Port(TEXT, ""),
    "server_timeout": Port(NUMBER, 0.0),
    "error_code_id": Port(WHOLE, 0, output=True),
    "error_msg": Port(TEXT, "", output=True),
}


class Asking(TreeNode):
    """Asks a server once, and ends as its answer says; a halt withdraws what was asked."""

    KIND: ClassVar[str]
    SERVER: ClassVar[str] = ""
    FIELDS: ClassVar[Mapping[str, str]] = {}
    """Field of the request by port."""
    IS_RECOVERY: ClassVar[bool] = False
    FEEDBACK: ClassVar[bool] = False
    """Whether ports tell how it goes while it runs."""
    _key: int | None = None
    _cancelled = False
    _asked: Mapping[str, Any] = {}

    def __init__(self, maker: Maker) -> None:
        super().__init__(maker)
        self.running.asking.append(self)

    def tick(self) -> Status:
        """Ask, or look for the answer."""
        if self._key is None:
            self.set_status(Status.RUNNING)
            if self.counts_as_recovery():
                board = self.running.root
                board.set(RECOVERIES, (board.get(RECOVERIES) or 0) + 1)
            self.ask()
            return Status.RUNNING
        if self._cancelled:
            self._key, self._cancelled = None, False
            return Status.SUCCESS
        answer = self.running.state.answers.get(self._key)
        if answer is None:
            self._write(self.running.state.feedback.get(self._key, {}))
            self.while_running()
            return Status.RUNNING
        self._key = None
        return self.take(answer)

    def ask(self) -> None:
        """Ask the server, in place of what was asked before."""
        self._asked = self.request()
        self._key = self.running.ask(self.KIND, self.server(), self._asked, self.FEEDBACK)

    def cancel(self) -> None:
        """Withdraw what was asked, as another node wants it; this one succeeds then, as Nav2's."""
        if self._key is not None and not self._cancelled:
            self.running.commands.append(Withdraw(self._key))
            self._cancelled = True

    def server(self) -> str:
        """Return the server's name."""
        return self.get("server_name") or self.SERVER

    def request(self) -> dict[str, Any]:
        """Return what is asked, by the names of the message's fields."""
        values = {field: self.get(port) for port, field in self.FIELDS.items()}
        return {field: value for field, value in values.items() if value is not None}

    def while_running(self) -> None:
        """Look whether something else is to be asked."""

    def counts_as_recovery(self) -> bool:
        """Tell whether this is one of the recoveries that feedback counts; the XML may deny it."""
        said = self.get("is_recovery") if "is_recovery" in self.PORTS else True
        return self.IS_RECOVERY and bool(said)

    def take(self, answer: Answer) -> Status:
        """Write what was found, and end."""
        if "error_code_id" in self.PORTS:
            self.put("error_code_id", 0 if answer.succeeded else answer.code)
            self.put("error_msg", "" if answer.succeeded else answer.message)
        self._write(answer.values)
        return Status.SUCCESS if answer.succeeded else Status.FAILURE

    def _write(self, values: Mapping[str, Any]) -> None:
        for name, value in values.items():
            if name in self.PORTS:
                self.put(name, value)

    def on_halt(self) -> None:
        """Withdraw what was asked."""
        self.cancel()
        self._key, self._cancelled = None, False
