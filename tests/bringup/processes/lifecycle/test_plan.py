"""Which transitions a lifecycle manager's commands stand for."""

from __future__ import annotations

import pytest

from bringup.processes.lifecycle.plan import Command, State, Step, Transition, Verdict, judge, plan

NODES = ("map_server", "amcl")
UP = [Transition.CONFIGURE, Transition.ACTIVATE]


def test_startup_configures_all_in_order_then_activates_all_in_order() -> None:
    assert plan(Command.STARTUP, NODES) == (
        Step("map_server", Transition.CONFIGURE),
        Step("amcl", Transition.CONFIGURE),
        Step("map_server", Transition.ACTIVATE),
        Step("amcl", Transition.ACTIVATE),
    )


def test_reset_takes_down_in_reverse_order() -> None:
    assert plan(Command.RESET, NODES) == (
        Step("amcl", Transition.DEACTIVATE),
        Step("map_server", Transition.DEACTIVATE),
        Step("amcl", Transition.CLEANUP),
        Step("map_server", Transition.CLEANUP),
    )


def _apply(command: Command, states: dict[str, State]) -> dict[str, State] | None:
    """Run a plan on states as obedient nodes would; None where a step is refused."""
    result = dict(states)
    for step in plan(command, tuple(states)):
        verdict = judge(step.transition, result[step.node])
        if verdict is Verdict.REFUSE:
            return None
        if verdict is Verdict.DO:
            result[step.node] = step.transition.end
    return result


@pytest.mark.parametrize(
    ("command", "end"),
    [
        (Command.STARTUP, State.ACTIVE),
        (Command.RESET, State.UNCONFIGURED),
        (Command.SHUTDOWN, State.FINALIZED),
    ],
)
@pytest.mark.parametrize("first", [State.UNCONFIGURED, State.INACTIVE, State.ACTIVE])
@pytest.mark.parametrize("second", [State.UNCONFIGURED, State.INACTIVE, State.ACTIVE])
def test_a_command_ends_the_same_from_every_mix_of_states(
    command: Command, end: State, first: State, second: State
) -> None:
    assert _apply(command, {"a": first, "b": second}) == {"a": end, "b": end}


def test_pause_and_resume_are_each_others_inverse() -> None:
    active = {"a": State.ACTIVE, "b": State.ACTIVE}
    paused = _apply(Command.PAUSE, active)
    assert paused == {"a": State.INACTIVE, "b": State.INACTIVE}
    assert _apply(Command.RESUME, paused) == active


@pytest.mark.parametrize("command", list(Command))
def test_a_command_given_twice_changes_nothing_more(command: Command) -> None:
    start = State.UNCONFIGURED if command in (Command.STARTUP, Command.CONFIGURE) else State.ACTIVE
    once = _apply(command, {"a": start})
    if once is not None:
        assert _apply(command, once) == once


@pytest.mark.parametrize("transition", UP)
@pytest.mark.parametrize("state", [State.FINALIZED, State.UNKNOWN])
def test_a_node_that_is_gone_cannot_be_brought_up(transition: Transition, state: State) -> None:
    assert judge(transition, state) is Verdict.REFUSE


def test_an_unconfigured_node_cannot_be_resumed() -> None:
    assert _apply(Command.RESUME, {"a": State.UNCONFIGURED}) is None
