"""Domain and discovery range, which decide who can see whom; and twins."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from bringup.doctor.snapshot import Finding, Snapshot
from bringup.doctor.table import groups_by_node

RANK = 3
_RANGES = ("OFF", "LOCALHOST", "SUBNET", "SYSTEM_DEFAULT")
_DOMAINS = range(102)  # beyond, ports collide with those that Linux gives out: ROS 2's docs
_OURS = "rmw_fastrtps_cpp"


def check(snapshot: Snapshot) -> Iterator[Finding]:
    """Yield settings that keep nodes from seeing each other, or let them see too many."""
    yield from _environment(snapshot.machine.environment)
    domain, domains = snapshot.domain, snapshot.machine.domains
    if domains and domain not in domains:
        what = f"a robot runs in ROS domain {domains[0]}, none here, in domain {domain}"
        yield Finding(what, f"export ROS_DOMAIN_ID={domains[0]}")
    hosts = {name for name in groups_by_node() if name.endswith("_host")}
    names = [node.rpartition("/") for node in snapshot.nodes]
    robots = sorted({namespace for namespace, _, name in names if name in hosts})
    if robots and "" not in robots:
        what = f"robots run below {', '.join(robots)}, none without a namespace"
        yield Finding(what, f"python -m bringup doctor --namespace {robots[0].strip('/')}")
    for node, count in sorted(Counter(snapshot.nodes).items()):
        if count > 1:
            remedy = (
                "end one, or start it under another name (--ros-args -r __node:=NAME); of two"
                " robots one needs a --namespace or a --domain-id of its own"
            )
            yield Finding(f"{count} nodes are called {node}", remedy)


def _environment(environment: dict[str, str]) -> Iterator[Finding]:
    chosen = environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    if chosen not in _RANGES:
        what = f"ROS_AUTOMATIC_DISCOVERY_RANGE={chosen} is none of {', '.join(_RANGES)}"
        yield Finding(what, "export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST")
    if chosen == "OFF":
        what = "ROS_AUTOMATIC_DISCOVERY_RANGE=OFF: no process sees another"
        yield Finding(what, "unset ROS_AUTOMATIC_DISCOVERY_RANGE")
    if chosen in ("SUBNET", "SYSTEM_DEFAULT"):
        what = (
            f"ROS_AUTOMATIC_DISCOVERY_RANGE={chosen}: every robot of the network is in this graph"
        )
        yield Finding(what, "unset it, or take a ROS_DOMAIN_ID of your own")
    if peers := environment.get("ROS_STATIC_PEERS", "").strip("; "):
        what = f"ROS_STATIC_PEERS={peers}: other hosts reach this robot"
        yield Finding(what, "unset ROS_STATIC_PEERS")
    if "ROS_LOCALHOST_ONLY" in environment:
        what = "ROS_LOCALHOST_ONLY is set, which overrides the discovery range"
        yield Finding(what, "unset ROS_LOCALHOST_ONLY")
    domain = environment.get("ROS_DOMAIN_ID", "0")
    if not (domain.isascii() and domain.isdigit() and int(domain) in _DOMAINS):
        yield Finding(f"ROS_DOMAIN_ID={domain} is none of 0 to 101", "export ROS_DOMAIN_ID=0")
    middleware = environment.get("RMW_IMPLEMENTATION", _OURS)
    if middleware != _OURS:
        what = f"RMW_IMPLEMENTATION={middleware}: nodes of {_OURS} may not be seen"
        yield Finding(what, "unset RMW_IMPLEMENTATION")
