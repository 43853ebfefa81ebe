"""Actions: what a launch description consists of."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, Union

from launch.launch_context import LaunchContext

Entities = Sequence["LaunchDescriptionEntity"]


class LaunchDescriptionEntity:
    """Base of all that is visited while launching."""

    def visit(self, context: LaunchContext) -> Entities | None:
        """Do it; return what is to be visited next."""
        raise NotImplementedError

    def describe(self) -> str:
        """Return it as text for people."""
        return f"{type(self).__name__}(...)"

    def get_sub_entities(self) -> Iterable[LaunchDescriptionEntity]:
        return ()

    def children(self) -> Iterable[LaunchDescriptionEntity]:
        """Yield what it holds, as far as it is known before it is visited."""
        return self.get_sub_entities()


class Condition:
    """Decides whether an action is done, by a function of the context."""

    def __init__(self, *, predicate: Callable[[LaunchContext], bool] | None = None) -> None:
        self._predicate = predicate

    def evaluate(self, context: LaunchContext) -> bool:
        return self._predicate is None or self._predicate(context)


class Action(LaunchDescriptionEntity):
    """Something to do, unless a condition says otherwise.

    Attributes of actions that begin with `__` have launch's names: tests of launch files read
    them, as `_Node__parameters`.
    """

    says_when_done = False
    """Whether it emits the event itself that it is done, later."""

    def __init__(self, *, condition: Condition | None = None) -> None:
        self.condition = self.__condition = condition

    @classmethod
    def parse(cls, entity: Any, parser: Any) -> tuple[type[Any], dict[str, Any]]:
        """Return the class and its arguments by an element of XML or YAML; `if` is seen to."""
        return cls, {}

    def visit(self, context: LaunchContext) -> Entities | None:
        """Do it if its condition holds; return what is to be visited next."""
        if self.condition is not None and not self.condition.evaluate(context):
            return None
        following = self.execute(context)
        if not self.says_when_done:
            self.say_done(context)
        return following

    def say_done(self, context: LaunchContext) -> None:
        """Emit the event that it is done, if a handler waits for it."""
        from launch.events import ExecutionComplete  # which builds on this module

        event = ExecutionComplete(action=self)
        if context.handlers(event):
            context.emit_event_sync(event)

    def execute(self, context: LaunchContext) -> Entities | None:
        """Do it; return what is to be visited next."""
        raise NotImplementedError


SomeEntitiesType = Union[LaunchDescriptionEntity, Iterable[LaunchDescriptionEntity]]  # noqa: UP007
SomeActionsType = Union[Action, Iterable[Action]]  # noqa: UP007
SomeEntitiesType_types_tuple = SomeActionsType_types_tuple = (LaunchDescriptionEntity, Iterable)


def entities(given: Any) -> list[LaunchDescriptionEntity]:
    """Return one or several entities, or none, as a list."""
    if given is None:
        return []
    return [given] if isinstance(given, LaunchDescriptionEntity) else list(given)
