"""`ros2 run nav2_util lifecycle_bringup`: nodes with a lifecycle brought up, one after another."""

from __future__ import annotations

from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, GetState

from bringup.ros2.client import Client, absolute
from bringup.ros2.errors import Ros2Error

_STEPS = {
    State.PRIMARY_STATE_UNCONFIGURED: Transition.TRANSITION_CONFIGURE,
    State.PRIMARY_STATE_INACTIVE: Transition.TRANSITION_ACTIVATE,
}


def main(words: list[str], patience: float = 60.0) -> None:
    """Configure and activate each node of a list.

    Args:
        patience: How long a service may take to be there, and to answer [s].

    Raises:
        Ros2Error: No node is named, or one is not active in the end.
    """
    if not words:
        raise Ros2Error("no node is named; valid: lifecycle_bringup NODE [NODE ...]")
    with Client(name="lifecycle_bringup") as client:
        for name in map(absolute, words):
            state = State()
            for _ in range(len(_STEPS) + 1):
                asked = GetState.Request()
                answer = client.call(GetState, f"{name}/get_state", asked, timeout=patience)
                state = answer.current_state
                if state.id not in _STEPS:
                    break
                step = ChangeState.Request(transition=Transition(id=_STEPS[state.id]))
                client.call(ChangeState, f"{name}/change_state", step, timeout=patience)
            if state.id != State.PRIMARY_STATE_ACTIVE:
                raise Ros2Error(f"{name} is {state.label}; its log says why")
            print(f"{name} is active", flush=True)
