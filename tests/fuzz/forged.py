"""A forged participant of another host: announced by hand, from another address.

`attack` does it in a network namespace with two addresses, where the machine allows one.
"""

from __future__ import annotations

import json
import os
import shutil
import socket
import struct
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ROBOT, FORGER = "192.0.2.1", "192.0.2.2"  # of RFC 5737, nobody's
DOMAIN = 7
SECONDS = 2.0  # of announcing; an open robot answers the first
_GROUP = "239.255.0.1"  # DDSI-RTPS 9.6.1.4.1
_BASE = 7400 + 250 * DOMAIN  # DDSI-RTPS 9.6.1.1
_PREFIX = bytes([1, 15, *range(10)])  # the vendor is eProsima, the rest any
_NAMESPACE = (
    f"ip link set lo up && ip address add {ROBOT}/32 dev lo && ip address add {FORGER}/32 dev lo"
    ' && ip route add 239.0.0.0/8 dev lo && ip link set lo multicast on && exec "$@"'
)


def attack(discovery_range: str) -> int | str:
    """Announce a participant to a node of ours; return the packets that come back.

    Args:
        discovery_range: The node's ROS_AUTOMATIC_DISCOVERY_RANGE; "" for what we do without.

    Returns:
        How many, or why there can be no such namespace here.
    """
    unshare = shutil.which("unshare")
    if unshare is None:
        return "no unshare here"
    within = [unshare, "--net", "--map-root-user", "sh", "-c", _NAMESPACE, "sh"]
    ours = ("FASTRTPS", "ROS_")
    kept = {name: value for name, value in os.environ.items() if not name.startswith(ours)}
    tried = _run([*within, "true"], kept)
    if tried.returncode != 0:
        return f"no namespace with two addresses here: {tried.stderr.strip()}"
    opened = {"ROS_AUTOMATIC_DISCOVERY_RANGE": discovery_range} if discovery_range else {}
    done = _run([*within, sys.executable, "-m", "tests.fuzz.forged"], kept | opened)
    if done.returncode != 0:
        raise AssertionError(f"the attack failed: {done.stderr}")
    return int(json.loads(done.stdout.splitlines()[-1]))


def _run(command: list[str], environment: dict[str, str]) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command,
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
        timeout=60.0,
        check=False,
    )


def _parameter(kind: int, content: bytes) -> bytes:
    return struct.pack("<HH", kind, len(content)) + content


def _announcement(address: str, port: int) -> bytes:
    """Return an RTPS message with one SPDP announcement, to be answered at a port."""
    locator = struct.pack("<iI", 1, port) + bytes(12) + socket.inet_aton(address)
    parameters = (
        (0x15, bytes([2, 3, 0, 0])),  # protocol version
        (0x16, bytes([1, 15, 0, 0])),  # vendor
        (0x50, _PREFIX + bytes([0, 0, 1, 0xC1])),  # participant
        (0x32, locator),  # metatraffic unicast
        (0x33, locator),  # metatraffic multicast
        (0x31, locator),  # default unicast
        (0x02, struct.pack("<iI", 100, 0)),  # lease [s]
        (0x58, struct.pack("<I", 0xC3F)),  # all endpoints of discovery
        (0x01, b""),  # the end
    )
    payload = b"\0\3\0\0" + b"".join(_parameter(*one) for one in parameters)
    data = struct.pack("<HH", 0, 16) + bytes([0, 0, 0, 0, 0, 1, 0, 0xC2])
    data += struct.pack("<iI", 0, 1) + payload
    submessage = struct.pack("<BBH", 0x15, 5, len(data)) + data
    return b"RTPS" + bytes([2, 3, 1, 15]) + _PREFIX + submessage


def _open_ports() -> set[int]:
    """Return every UDP port that is open, those of discovery among them."""
    lines = Path("/proc/net/udp").read_text(encoding="ascii").splitlines()[1:]
    return {int(line.split()[1].split(":")[1], 16) for line in lines}


def _announce() -> int:
    """Announce to every open port and to the group for a while; return what is answered."""
    answers = 0
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as forger:
        forger.bind((FORGER, 0))
        forger.settimeout(0.1)
        forger.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(FORGER))
        packet = _announcement(*forger.getsockname())
        ports = _open_ports() - {forger.getsockname()[1]}
        to = [(ROBOT, port) for port in sorted(ports)] + [(_GROUP, _BASE)]
        end = time.monotonic() + SECONDS
        while time.monotonic() < end:
            for address in to:
                forger.sendto(packet, address)
            try:
                while True:
                    forger.recv(65536)
                    answers += 1
            except TimeoutError:
                pass
    return answers


def main() -> int:
    """Have a node in this namespace and attack it; print the number of answers."""
    from rclpy.node import Node

    from arjuna_core.ros.context import new_context

    context = new_context(DOMAIN)
    node = Node("robot", context=context)
    sys.stdout.write(f"{_announce()}\n")
    node.destroy_node()
    context.shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
