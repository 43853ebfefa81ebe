"""The findings of all checks, as a page and as JSON."""

from __future__ import annotations

import json
from dataclasses import asdict

from bringup.doctor.checks import CHECKS
from bringup.doctor.snapshot import Finding, Snapshot


def diagnose(snapshot: Snapshot) -> dict[str, list[Finding]]:
    """Return the findings of every check, by its name."""
    return {name: list(check(snapshot)) for name, check in CHECKS.items()}


def page(snapshot: Snapshot, findings: dict[str, list[Finding]]) -> str:
    """Return the findings as one screen: a line each, with its remedy."""
    count = len(snapshot.nodes)
    graph = f"{count} nodes" if count else "no robot runs"
    where = f"domain {snapshot.domain}"
    if snapshot.namespace != "/":
        where += f", {snapshot.namespace}"
    lines = [f"{where}, {graph}, listened for {snapshot.duration:.1f} s"]
    well = [name for name, found in findings.items() if not found]
    lines.append(f"ok        {', '.join(well)}")
    for name, found in findings.items():
        lines += [f"{name}\n  {finding.what}\n    -> {finding.remedy}" for finding in found]
    if snapshot.robot.log:
        lines += ["said lately", *(f"  {node}: {text}" for node, text in snapshot.robot.log)]
    return "\n".join(lines)


def as_json(snapshot: Snapshot, findings: dict[str, list[Finding]]) -> str:
    """Return the findings, and what they were made from, as JSON."""
    rows = [
        {"check": name, **asdict(finding)} for name, found in findings.items() for finding in found
    ]
    return json.dumps({"findings": rows, "snapshot": asdict(snapshot)}, indent=2)
