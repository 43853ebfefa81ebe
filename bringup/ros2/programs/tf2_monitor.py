"""`ros2 run tf2_ros tf2_monitor`: how old transforms are as they come, and how often they come."""

from __future__ import annotations

import argparse
import time
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import yaml
from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from tf2_msgs.msg import TFMessage
from tf2_ros import Buffer, TransformListener

from arjuna_core.ros import qos
from arjuna_core.ros.convert import seconds
from bringup.ros2.client import Client

_PERIOD, _STEP = 10.0, 0.5  # [s] between reports, and between looks at a chain
_KEPT = 1000
_NOBODY = "<no authority available>"


def _recent() -> deque[float]:
    return deque(maxlen=_KEPT)


@dataclass
class Delays:
    """Ages of transforms as they come [s], by frame and by message, and when messages come.

    Attributes:
        now: The time of /clock, where it is published [s].
    """

    now: float | None = None
    frames: dict[str, deque[float]] = field(default_factory=dict)
    messages: deque[float] = field(default_factory=_recent)
    arrivals: deque[float] = field(default_factory=_recent)
    net: deque[float] = field(default_factory=_recent)

    def age(self, stamp: float) -> float:
        """Return the age of a stamp [s]."""
        return (time.time() if self.now is None else self.now) - stamp

    def add(self, message: TFMessage) -> None:
        """Note a message."""
        ages = {t.child_frame_id: self.age(seconds(t.header.stamp)) for t in message.transforms}
        for frame, age in ages.items():
            self.frames.setdefault(frame, _recent()).append(age)
        self.messages.append(_mean(ages.values()))
        self.arrivals.append(time.monotonic())

    def lines(self, chain: Sequence[str] = ()) -> list[str]:
        """Return the report on all frames, or on those of a chain from its last to its first."""
        head = [f"RESULTS: for {f'{chain[-1]} to {chain[0]}' if chain else 'all Frames'}"]
        if chain:
            net = f"Net delay     avg = {_mean(self.net):g}: max = {max(self.net, default=0.0):g}"
            head += [f"Chain is: {' -> '.join(chain)}", net]
        shown = [name for name in sorted(self.frames) if name in chain or not chain]
        frames = [
            f"Frame: {name}, published by {_NOBODY}, Average Delay: {_mean(self.frames[name]):g}, "
            f"Max Delay: {max(self.frames[name]):g}"
            for name in shown
        ]
        span = self.arrivals[-1] - self.arrivals[0] if self.arrivals else 0.0
        rate = f"{_NOBODY} {len(self.arrivals) / max(span, 1e-8):g} Hz"
        delay = f"Average Delay: {_mean(self.messages):g} Max Delay: {max(self.messages):g}"
        broadcasters = [f"Node: {rate}, {delay}"] if self.messages else []
        return ["", "", "", *head, "", "Frames:", *frames, "", "All Broadcasters:", *broadcasters]


def _mean(values: Iterable[float]) -> float:
    kept = list(values)
    return sum(kept) / len(kept) if kept else 0.0


def chain_of(parents: Mapping[str, str], source: str, target: str) -> list[str]:
    """Return the frames from a source up to what it shares with a target, and down to that."""
    ways = []
    for frame in (source, target):
        way = [frame]
        while way[-1] in parents:
            way.append(parents[way[-1]])
        ways.append(way)
    up, down = ways
    shared = next(frame for frame in up if frame in down)
    return [*up[: up.index(shared) + 1], *reversed(down[: down.index(shared)])]


def main(words: list[str]) -> None:
    """Report every 10 s, on all frames or on those between two, until interrupted."""
    parser = argparse.ArgumentParser(prog="ros2 run tf2_ros tf2_monitor", description=main.__doc__)
    parser.add_argument("frames", nargs="*", metavar="FRAME", help="target and source frame")
    frames = parser.parse_args(words).frames
    if len(frames) not in (0, 2):
        parser.error("two frames, or none")
    with Client(name="tf2_monitor") as client:
        _monitor(client, *frames)


def _monitor(client: Client, target: str = "", source: str = "") -> None:
    buffer, delays = Buffer(node=client.node), Delays()
    TransformListener(buffer, client.node)

    def on_clock(message: Clock) -> None:
        delays.now = seconds(message.clock)

    client.node.create_subscription(Clock, "/clock", on_clock, qos.CLOCK)
    client.run_until(lambda: delays.now is not None, 1.0, required=False)
    chain: list[str] = []
    if target:
        waits = f"Waiting for transform chain to become available between {target} and {source} "
        print(waits, end="", flush=True)
        while not client.run_until(
            lambda: bool(buffer.can_transform(target, source, Time())), 1.0, required=False
        ):
            print(".", end="", flush=True)
        known = yaml.safe_load(buffer.all_frames_as_yaml())
        parents = {child: str(frame["parent"]) for child, frame in known.items()}
        chain = chain_of(parents, source, target)
        print()
    for topic, profile in (("/tf", qos.TF), ("/tf_static", qos.TF_STATIC_SUBSCRIPTION)):
        client.node.create_subscription(TFMessage, topic, delays.add, profile)
    while True:
        for _ in range(round(_PERIOD / _STEP)):
            client.pause(_STEP)
            if chain and buffer.can_transform(target, source, Time()):
                stamp = buffer.lookup_transform(target, source, Time()).header.stamp
                delays.net.append(delays.age(seconds(stamp)))
        print("\n".join(delays.lines(chain)), flush=True)
