"""`calibrate`: find a robot's effective track width and wheel radius, and write them down."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from arjuna_core.arrays import Floats
from arjuna_core.files.shipped import shipped_file
from arjuna_core.files.whole_file import emptied_folder, writing

if TYPE_CHECKING:
    from arjuna_sim.devices.calibration import Calibration, Comparison

mpl.use("Agg")
_KINDS = ("straight", "spin", "arc")
_PATH_BOUND, _TURN_BOUND = 0.02, 0.04  # relative errors within which a calibration is good
PARAMETERS, SNIPPET, PICTURE = "calibration.yaml", "calibration.urdf.xml", "calibration.png"


def write_calibration(robot: Path | None, world: Path | None, out: Path) -> str:
    """Calibrate a robot; write parameters, URDF snippet and picture; return the report.

    The shipped one if None, in a world with 4 m of free ground, the empty one if None.

    Raises:
        ArjunaError: An input cannot be used, or the folder not be written.
    """
    from arjuna_sim.calibrate import calibrate_robot

    robot = robot or shipped_file("urdf/arjuna.urdf")
    result = calibrate_robot(robot, world or shipped_file("worlds/empty.world"))
    figure = _draw(result, robot.name)
    with writing(emptied_folder(out)):
        (out / PARAMETERS).write_text(_parameters(result, robot.name), encoding="utf-8")
        (out / SNIPPET).write_text(
            "<!-- For the drive plugin of the robot's URDF, instead of a parameter file. -->\n"
            f"<effectiveTrackWidth>{result.found.track:.5f}</effectiveTrackWidth>\n"
            f"<effectiveWheelRadius>{result.found.radius:.6f}</effectiveWheelRadius>\n",
            encoding="utf-8",
        )
        figure.savefig(out / PICTURE, dpi=110)
    return _report(result, out)


def _parameters(result: Calibration, name: str) -> str:
    found, noise = result.found, result.noise
    return (
        f"# The calibration of {name}: python -m bringup sim --robot {name} --params {PARAMETERS}\n"
        "sim:\n  ros__parameters:\n    drive:\n"
        f"      effective_track_width: {found.track:.5f}\n"
        f"      effective_wheel_radius: {found.radius:.6f}\n"
        "    odometry:\n"
        f"      linear_noise: {noise.linear_noise:.5f}\n"
        f"      angular_noise: {noise.angular_noise:.5f}\n"
        f"      drift_noise: {noise.drift_noise:.5f}\n"
    )


def _report(result: Calibration, out: Path) -> str:
    lines = [
        f"{'':<12}{'nominal':>10}{'effective':>11}",
        f"{'track':<12}{result.nominal.track:>8.4f} m{result.found.track:>9.4f} m",
        f"{'radius':<12}{result.nominal.radius:>8.4f} m{result.found.radius:>9.4f} m",
        "greatest errors of odometry, before and after",
    ]
    for kind in _KINDS:
        before, after = (_worst(rows, kind) for rows in (result.before, result.after))
        if kind != "spin":
            lines.append(f"  {kind:<9} distance {before[0]:8.2%} {after[0]:8.2%}")
        if kind != "straight":
            lines.append(f"  {kind:<9} turn     {before[1]:8.2%} {after[1]:8.2%}")
    path, turn = (max(_worst(result.after, kind)[i] for kind in _KINDS) for i in (0, 1))
    good = path <= _PATH_BOUND and turn <= _TURN_BOUND
    lines.append(f"within {_PATH_BOUND:.0%} and {_TURN_BOUND:.0%}: {'yes' if good else 'no'}")
    lines.append(f"files        {out}: {PARAMETERS}, {SNIPPET}, {PICTURE}")
    return "\n".join(lines)


def _worst(rows: Sequence[Comparison], kind: str) -> tuple[float, float]:
    some = [row for row in rows if row.manoeuvre.kind == kind]
    return max(abs(row.path_error) for row in some), max(abs(row.turn_error) for row in some)


def _draw(result: Calibration, name: str) -> Figure:
    figure = Figure(figsize=(15.0, 5.0))
    axes = figure.subplots(1, 3)
    titles = ("before: the wheels' separation", "after: the effective track")
    tracks, paths = (result.nominal, result.found), (result.path_before, result.path_after)
    for panel, title, kinematics, path in zip(axes, titles, tracks, paths, strict=False):
        _draw_paths(panel, result.check.truth, path)
        panel.set_title(f"{name}, {title} ({kinematics.track:.3f} m)", fontsize=10)
    _draw_errors(axes[2], result)
    figure.tight_layout()
    return figure


def _draw_paths(panel: mpl.axes.Axes, truth: Floats, odometry: Floats) -> None:
    panel.plot(truth[:, 0], truth[:, 1], color="black", linewidth=2.5, label="truth")
    panel.plot(odometry[:, 0], odometry[:, 1], color="tab:red", linewidth=1.2, label="odometry")
    panel.plot(0.0, 0.0, "o", color="black", label="start")
    panel.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
    panel.grid(alpha=0.3)
    panel.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncol=3, fontsize=8)


def _draw_errors(panel: mpl.axes.Axes, result: Calibration) -> None:
    parts = [row.manoeuvre for row in result.after]
    rows_at = np.arange(len(parts))
    for shift, rows, colour, label in (
        (-0.2, result.before, "tab:red", "before"),
        (0.2, result.after, "tab:green", "after"),
    ):
        errors = [100.0 * abs(row.turn_error or row.path_error) for row in rows]
        panel.barh(rows_at + shift, errors, 0.4, color=colour, label=label)
    names = [f"{m.kind} {m.command.x:g} m/s {m.command.yaw_rate:g} rad/s" for m in parts]
    panel.set_yticks(rows_at, names, fontsize=8)
    panel.axvline(100.0 * _TURN_BOUND, color="black", linestyle=":", label="bound of turns")
    panel.set(xscale="log", xlabel="error of turn (straight: of distance) [%]")
    panel.invert_yaxis()
    panel.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncol=3, fontsize=8)
