"""What a command is typed like: the examples at the end of each `--help`."""

from __future__ import annotations

EXAMPLES: dict[str, tuple[str, ...]] = {
    "lesson": ("lesson 1", "lesson 3 --list", "lesson 4 --part 2"),
    "sim": (
        "sim",
        "sim --robot urdf/burger.urdf --world worlds/pillar_arena.world --at -2 -0.5",
        "sim --at -2 0.5 --yaw 1.57",
        "sim --check my.urdf",
        "sim --viewer",
        "sim --namespace a --namespace b --at -2 0 --at 2 2",
        "sim --world worlds/office.world --record",
    ),
    "slam": (
        "slam",
        "slam --params guides/ros2/params.yaml",
        "slam --param mode:=lifelong",
        "slam --offline drive.mcap",
    ),
    "nav": (
        "nav --map maps/arjuna_room.yaml",
        "nav --slam",
        "nav --offline drive.mcap --map m.yaml",
    ),
    "demo": (
        "demo",
        "demo --seed 7 --out out/seven",
        "demo --robot my.urdf --world my.world --waypoints points.yaml --no-kidnap",
    ),
    "robot": ("robot --map my_map.yaml", "robot --slam"),
    "teleop": ("teleop", "teleop --keys twist --speed 0.2"),
    "avoid": ("avoid", "avoid --distance 1.0 --duration 30"),
    "goto": ("goto 2 2", "goto 1.5 -1 3.14"),
    "tour": ("tour guides/arjuna/waypoints.yaml",),
    "explore": ("explore", "explore --timeout 300"),
    "initial-pose": ("initial-pose 0 0", "initial-pose 2.5 1 1.57"),
    "save-map": ("save-map out/my_map",),
    "view": ("view", "view --foxglove", "view --rerun --save drive.rrd"),
    "doctor": ("doctor", "doctor --json"),
    "top": ("top",),
    "tf": ("tf", "tf --picture frames.png"),
    "params": (
        "params dump",
        "params check my.yaml",
        "params diff my.yaml",
        "params convert amcl.launch",
    ),
    "entity": (
        "entity list",
        "entity spawn crate box:0.5,0.5,0.5 --at 2 0",
        'entity spawn bob person --path "1,0 3,0"',
        "entity move robot 0 2",
    ),
    "world": ("world pause", "world step 50", "world reset", "world load worlds/office.world"),
    "record": ("record", "record -o out/bag --topics /scan /odom"),
    "play": ("play out/bag", "play out/bag --rate 2 --clock"),
    "info": ("info out/bag",),
    "replay": ("replay out/bag", "replay out/bag --picture drive.png --at 12"),
    "calibrate": ("calibrate --robot my.urdf --out out/calibration",),
    "bench": ("bench slam",),
    "campaign": ("campaign campaigns/goals.yaml", "campaign --compare out/one out/other"),
    "tune": (
        "tune campaigns/tuning/race_track.yaml",
        "tune campaigns/tuning/race_track.yaml --trials 100",
    ),
}
"""What to type after `python -m bringup`, by the command."""


def page(prog: str, command: str) -> str:
    """Return the examples of a command, empty where there are none.

    Args:
        prog: How the user called the program.
        command: The command's name.
    """
    lines = [f"  {prog} {line}" for line in EXAMPLES.get(command, ())]
    return "\n".join(["examples:", *lines]) if lines else ""
