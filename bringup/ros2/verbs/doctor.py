"""`ros2 doctor`, or `ros2 wtf`."""

from __future__ import annotations

from bringup.ros2.verbs import forward


def run(words: list[str]) -> None:
    """Look for what is wrong; ros2cli's switches of its report change nothing: all is said."""
    if words[:1] == ["hello"]:
        from bringup.ros2.verbs.multicast import hello  # the middleware may be what is wrong

        hello(words[1:])
        return
    switches = ["-r", "--report", "-rf", "--report-failed", "-iw", "--include-warnings"]
    forward.arjuna("doctor", [word for word in words if word not in switches])
