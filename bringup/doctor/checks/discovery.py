"""Domain and discovery range: who can see whom; and twins."""

from __future__ import annotations

from collections import Counter

from bringup.doctor.finding import Finding
from bringup.doctor.snapshot import Snapshot
from bringup.doctor.table import groups_by_node

_RANGES = ("OFF", "LOCALHOST", "SUBNET", "SYSTEM_DEFAULT")
_DOMAINS = range(102)  # beyond, ports collide with those that Linux gives out: ROS 2's docs
_OURS = "rmw_fastrtps_cpp"


def check(snapshot: Snapshot) -> list[Finding]:
    """Return what keeps nodes from seeing each other, or lets them see too many."""
    environment = snapshot.machine.environment
    return [
        *_range(environment),
        *_domain(environment.get("ROS_DOMAIN_ID", "0")),
        *_middleware(environment.get("RMW_IMPLEMENTATION", _OURS)),
        *_elsewhere(snapshot),
        *_below(snapshot),
        *_twins(snapshot.nodes),
    ]


def _range(environment: dict[str, str]) -> list[Finding]:
    chosen = environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    found = []
    if chosen not in _RANGES:
        what = f"ROS_AUTOMATIC_DISCOVERY_RANGE={chosen} is none of {', '.join(_RANGES)}"
        found.append(Finding(what, "export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST"))
    if chosen == "OFF":
        what = "ROS_AUTOMATIC_DISCOVERY_RANGE=OFF: no process sees another"
        found.append(Finding(what, "unset ROS_AUTOMATIC_DISCOVERY_RANGE"))
    if chosen == "SUBNET":
        what = "ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET: every robot of the network is in this graph"
        found.append(Finding(what, "unset it, or take a ROS_DOMAIN_ID of your own"))
    if "ROS_LOCALHOST_ONLY" in environment:
        what = "ROS_LOCALHOST_ONLY is set, which overrides the discovery range"
        found.append(Finding(what, "unset ROS_LOCALHOST_ONLY"))
    return found


def _domain(domain: str) -> list[Finding]:
    if domain.isascii() and domain.isdigit() and int(domain) in _DOMAINS:
        return []
    return [Finding(f"ROS_DOMAIN_ID={domain} is none of 0 to 101", "export ROS_DOMAIN_ID=0")]


def _middleware(chosen: str) -> list[Finding]:
    if chosen == _OURS:
        return []
    what = f"RMW_IMPLEMENTATION={chosen}: what runs with {_OURS} is not seen for sure"
    return [Finding(what, "unset RMW_IMPLEMENTATION")]


def _elsewhere(snapshot: Snapshot) -> list[Finding]:
    others = [domain for domain in snapshot.machine.domains if domain != snapshot.domain]
    if not others or snapshot.domain in snapshot.machine.domains:
        return []
    here = f"none here, in domain {snapshot.domain}"
    cure = f"export ROS_DOMAIN_ID={others[0]}"
    return [Finding(f"a robot runs in ROS domain {others[0]}, {here}", cure)]


def _below(snapshot: Snapshot) -> list[Finding]:
    """Name the robots below a namespace where none is without."""
    hosts = {name for name in groups_by_node() if name.endswith("_host")}
    places = [node.rpartition("/") for node in snapshot.nodes]
    robots = sorted({namespace for namespace, _, name in places if name in hosts})
    if not robots or "" in robots:
        return []
    what = f"robots run below {', '.join(robots)}, none without a namespace"
    return [Finding(what, f"python -m bringup doctor --namespace {robots[0].strip('/')}")]


def _twins(nodes: tuple[str, ...]) -> list[Finding]:
    return [
        Finding(
            f"{count} nodes are called {node}",
            "stop one; two robots need domains of their own (ROS_DOMAIN_ID)",
        )
        for node, count in sorted(Counter(nodes).items())
        if count > 1
    ]
