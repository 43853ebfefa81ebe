"""The commands of `arjuna`: one file each, with `configure(parser)` and `run(arguments)`.

`configure` is argparse only, so that `--help` is instant; `run` imports what it needs, raises
ArjunaError where an input cannot be used, and returns the exit code.
"""

from __future__ import annotations

COMMANDS = {
    "Learn": {
        "lesson": "a page of the tutorial, command by command",
    },
    "Run the robot": {
        "sim": "the simulated robot in its world, in real time",
        "slam": "mapping and localization of a running robot, or of a log",
        "nav": "localization and navigation of a running robot on a map, or AMCL of a log",
        "robot": "the same of a real robot, whose drivers run beside it",
        "demo": "explore, map, drive waypoints, be carried off and drive home, as fast as it goes",
    },
    "Drive": {
        "teleop": "drive by keys",
        "avoid": "drive about by itself, away from what the lidar sees",
        "goto": "drive to a place of the map",
        "tour": "drive to the way-points of a file, one after the other",
        "explore": "drive to the edges of the map until all is seen (beside nav --slam)",
        "initial-pose": "tell AMCL where the robot is",
        "save-map": "write the map to files",
    },
    "See": {
        "view": "the robot, its map and its plans in a browser, with tools to command it",
    },
    "Look into it": {
        "doctor": "what is wrong with the machine and the running robot, and the cure",
        "top": "the nodes: state, CPU, rate of the main topic, last warning",
        "tf": "the tree of frames, as text and picture",
        "params": "all parameters, a file checked or converted, two files compared",
    },
    "The world": {
        "entity": "spawn, move, delete and list what is in the simulation",
        "world": "pause, step, reset and replace the simulated world",
    },
    "Recordings": {
        "record": "write what the robot says into a recording, byte for byte",
        "play": "publish a recording again",
        "info": "what a recording holds and lacks, and its repair",
        "replay": "see a recording: in rerun's viewer, as its file, or as a picture",
    },
    "Measure": {
        "calibrate": "find a robot's effective track width and wheel radius by driving it",
        "bench": "measure a part of the robot",
        "campaign": "one command many times, and what the runs say together",
        "tune": "parameters searched by machine, trial by trial",
    },
}
"""What each command does, under the headings of the first page, in its order."""
FOLDERS = {"Drive": "drive.", "Look into it": "tools.", "Recordings": "recordings."}
"""Where the files of a heading's commands are, if not here."""
