"""`nav --offline`: AMCL on a recording and a map; trajectory, report and picture into a folder."""

from __future__ import annotations

import argparse
from collections import Counter

import numpy as np

from arjuna_slam.offline_amcl import localize_log
from bringup.offline import files
from bringup.parameters.files import for_node, load_parameters, merged, shipped_parameters
from bringup.parameters.sources import of_words


def run(arguments: argparse.Namespace) -> str:
    """Localize the robot of a recording on a map and write where it was.

    Args:
        arguments: What `cli_parser.parse` returned.

    Returns:
        The report as text.

    Raises:
        ArjunaError: An input cannot be used, or the folder not be written.
    """
    given = of_words(arguments.param).values
    parameters = merged(shipped_parameters(), load_parameters(arguments.params), given)
    progress = files.Progress(arguments.out)
    localized = localize_log(
        arguments.offline,
        arguments.map,
        for_node(parameters, "amcl"),
        scan_topic=arguments.scan_topic or "",
        odom_topic=arguments.odom_topic or "",
        seed=arguments.seed or 0,
        watch=progress.watch,
    )
    trajectory = [(fix.stamp, fix.T_map_base) for fix in localized.fixes]
    states = Counter(fix.status.value for fix in localized.fixes)
    report = {
        **progress.report(arguments.offline, trajectory),
        "map": str(arguments.map),
        "quality": float(np.mean([fix.quality for fix in localized.fixes])),
        "scans_by_status": dict(sorted(states.items())),
    }
    files.write(arguments.out, report, localized.grid, trajectory)
    counts = ", ".join(f"{n} {state}" for state, n in sorted(states.items()))
    rows = [
        ("scans", f"{report['scans']}: {counts}"),
        ("quality", f"{report['quality']:.2f} in the mean"),
    ]
    made = f"{arguments.out}: {', '.join(files.ARTIFACTS)}"
    return files.summary("amcl", report, rows, localized.problems, made)
