"""`slam --offline`: SLAM on a log; map, trajectory, report and picture into a folder."""

from __future__ import annotations

import argparse
import math
import resource

from arjuna_core.files.maps import save_map
from arjuna_slam.offline import MappedLog, map_log
from bringup.offline import files
from bringup.parameters.files import for_node, load_parameters, merged, shipped_parameters
from bringup.parameters.sources import of_words


def run(arguments: argparse.Namespace) -> str:
    """Run SLAM over a log and write its results.

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
    mapped = map_log(
        arguments.offline,
        for_node(parameters, "slam_toolbox"),
        scan_topic=arguments.scan_topic or "",
        odom_topic=arguments.odom_topic or "",
        relations=arguments.relations,
        watch=progress.watch,
    )
    frame = mapped.grid.frame
    report = {
        **progress.report(arguments.offline, mapped.trajectory),
        **mapped.counts,
        "memory_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
        **_relations(mapped),
        "map": {"width": frame.width, "height": frame.height, "resolution": frame.resolution},
    }
    save_map(mapped.grid, arguments.out / "map")
    files.write(arguments.out, report, mapped.grid, mapped.trajectory)
    rows = [
        ("scans", f"{report['scans']}, {report['scans_skipped']} skipped"),
        ("keyframes", f"{report['keyframes']}, {report['closures']} loop edges"),
        ("map", f"{frame.width} x {frame.height} cells"),
    ]
    if mapped.error is not None:
        metres, degrees = mapped.error.translation[0], math.degrees(mapped.error.rotation[0])
        rows.append(("relations", f"{metres:.4f} m, {degrees:.3f} deg mean error"))
    made = f"{arguments.out}: map.pgm, map.yaml, {', '.join(files.ARTIFACTS)}"
    return files.summary("slam", report, rows, mapped.problems, made)


def _relations(mapped: MappedLog) -> dict[str, dict[str, float]]:
    error = mapped.error
    if error is None:
        return {}
    rotation = [math.degrees(value) for value in error.rotation]
    names = "translation_m", "translation_sd_m", "rotation_deg", "rotation_sd_deg", "count"
    values = *error.translation, *rotation, error.count
    return {"relations": dict(zip(names, values, strict=True))}
