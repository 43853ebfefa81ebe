"""A behavior tree whose questions the test answers."""

from __future__ import annotations

from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL
from arjuna_nav.trees.exchange import Answer, Ask, Battery, TreeState
from arjuna_nav.trees.node import Status, Tree
from arjuna_nav.trees.xml_file import build_tree


class Play:
    """A tree whose questions the test answers."""

    def __init__(self, xml: str, **entries: object) -> None:
        text = f'<root BTCPP_format="4"><BehaviorTree ID="T">{xml}</BehaviorTree></root>'
        self.tree: Tree = build_tree(text, "test.xml")
        for name, value in entries.items():
            self.tree.blackboard.set(name, value)
        self.now = 0.0
        self.pose: SE2 | None = SE2()
        self.velocity, self.measured_at = STILL, 0.0
        self.feedback: dict[str, dict[str, object]] = {}
        self.batteries: dict[str, Battery] = {}
        self.frames: dict[tuple[str, str], SE2] = {}
        self.open: dict[str, int] = {}
        self.withdrawn: list[int] = []

    def tick(self, dt: float = 0.1, **answers: Answer | bool) -> Status:
        """Tick once; answers are by the kind of what is open."""
        self.now += dt
        given = {
            self.open.pop(kind): Answer(value) if isinstance(value, bool) else value
            for kind, value in answers.items()
        }
        state = TreeState(
            self.now,
            self.pose,
            self.velocity,
            self.measured_at,
            given,
            {self.open[kind]: self.feedback.pop(kind) for kind in list(self.feedback)},
            batteries=self.batteries,
            transform=lambda parent, child: self.frames.get((parent, child)),
            mean_velocity=lambda: self.velocity,
        )
        status, commands = self.tree.tick(state)
        for command in commands:
            if isinstance(command, Ask):
                self.open[command.kind] = command.key
            else:
                self.withdrawn.append(command.key)
                self.open = {k: v for k, v in self.open.items() if v != command.key}
        return status

    def get(self, name: str) -> object:
        return self.tree.blackboard.get(name)
