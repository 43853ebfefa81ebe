"""An exercise: its sheet, what is handed out and how it is graded, of a YAML file and a script."""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, NamedTuple, get_args, get_origin, get_type_hints

from arjuna_core.errors import ArjunaError, InputFileError, nearest
from arjuna_core.files.input_file import read_bytes
from arjuna_core.files.shipped import found_or_shipped, shipped_file
from arjuna_core.files.whole_file import emptied_folder
from arjuna_core.files.yaml_file import check_keys, read_yaml

FOLDER = "homework"
_LARGEST, _MANY = 1 << 20, 50
"""Of a submission: a file's size [bytes], and how many files."""


class ExerciseError(InputFileError):
    """An exercise's file or script cannot be used."""


class SubmissionError(InputFileError):
    """A submission cannot be graded; it has no points."""


class Mark(NamedTuple):
    """A criterion's share of its points, 0 to 1, and what went wrong if it is not all."""

    share: float
    why: str = ""

    @classmethod
    def of(cls, value: float, good: float, bad: float, why: str) -> Mark:
        """Return all of a criterion up to a good value, nothing from a bad one, between them less.

        Args:
            why: `{}` stands for the value, without its sign.
        """
        share = (bad - value) / (bad - good) if math.isfinite(value) else 0.0
        share = min(max(share, 0.0), 1.0)
        return cls(share, why.format(f"{abs(value):.2f}"))


@dataclass(frozen=True)
class Criterion:
    """A name, the most points and what they are for."""

    name: str
    points: float
    about: str


@dataclass(frozen=True)
class Exercise:
    """Content of a YAML file; `docs/homework.md` has its keys.

    Attributes:
        submit: The file that is handed in; the first of several is the one that is run.
        criteria: Each is a function of the script beside the YAML file.
        function: Whether the file's functions are called, in place of running it as a node.
        duration: How long the robot is watched [s].
        rest: How long after the program's end [s].
        start: The robot's, in the world [m, m, rad].
        map: What pictures and the robot's map server show.
        stacks: What runs beside the simulator.
        listen: Topics from the robot, of the grader too: `NAME` or `NAME TYPE`.
        publish: Topics to it.
        drive: `topic` and a `table` of time, speed and turn rate, which the grader drives.
        parameters: Of nodes, as a parameter file has them without `ros__parameters`.
        parameters_of: The nodes whose parameters the submission sets.
        goals: Poses, for the script and the picture [m, m, rad].
        data: Files that are handed out too.
    """

    path: Path
    title: str
    submit: tuple[str, ...]
    task: str
    criteria: tuple[Criterion, ...]
    skeleton: str = ""
    function: bool = False
    seed: int = 1
    duration: float = 0.0
    rest: float = 2.0
    world: str = "worlds/empty.world"
    robot: str = ""
    start: tuple[float, ...] = (0.0, 0.0, 0.0)
    map: str = ""
    stacks: tuple[str, ...] = ()
    listen: tuple[str, ...] = ()
    publish: tuple[str, ...] = ()
    drive: Mapping[str, Any] = field(default_factory=dict)
    parameters: Mapping[str, Any] = field(default_factory=dict)
    parameters_of: tuple[str, ...] = ()
    goals: tuple[tuple[float, ...], ...] = ()
    data: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Its name."""
        return self.path.stem

    @property
    def points(self) -> float:
        """The most points."""
        return sum(one.points for one in self.criteria)

    @property
    def runs(self) -> bool:
        """True if what is handed in is a program."""
        return self.submit[0].endswith(".py")

    def judges(self) -> dict[str, Callable[[Any], Mark]]:
        """Return the script's function of each criterion.

        Raises:
            ExerciseError: The script cannot be imported, or lacks one.
        """
        script = self.path.with_suffix(".py")
        spec = importlib.util.spec_from_file_location(f"homework_{self.name}", script)
        if not script.is_file() or spec is None or spec.loader is None:
            raise ExerciseError(script, "is missing; valid: a function for each criterion")
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        missing = [one.name for one in self.criteria if not hasattr(module, one.name)]
        if missing:
            raise ExerciseError(script, f"has no function {', '.join(missing)}")
        return {one.name: getattr(module, one.name) for one in self.criteria}


def exercises() -> dict[str, Path]:
    """Return the exercises that ship with Arjuna, by name."""
    return {path.stem: path for path in sorted(shipped_file(FOLDER).glob("*.yaml"))}


def load_exercise(name: str) -> Exercise:
    """Return an exercise by its name, or of a YAML file.

    Raises:
        ArjunaError: There is none of that name, or a key or value is not valid.
    """
    known = exercises()
    path = Path(name) if name.endswith((".yaml", ".yml")) else known.get(name)
    if path is None:
        raise ArjunaError(f"no homework '{name}'; {nearest(name, known)}, or a YAML file")
    content, keys = read_yaml(path, ExerciseError), [f.name for f in fields(Exercise)][1:]
    check_keys(path, content, keys, ("title", "submit", "task", "criteria"), ExerciseError)
    try:
        return Exercise(path, **{key: _value(key, value) for key, value in content.items()})
    except (TypeError, ValueError, AttributeError) as error:
        raise ExerciseError(path, str(error)) from error


def _value(key: str, value: Any) -> Any:
    if key == "criteria":
        return tuple(_criterion(str(name), one) for name, one in value.items())
    if key == "goals":
        return tuple(tuple(map(float, pose)) for pose in value)
    kind = get_type_hints(Exercise)[key]
    is_list = get_origin(kind) is tuple
    values = value if is_list and isinstance(value, list) else [value]
    one = get_args(kind)[0] if is_list else get_origin(kind) or kind
    if not all(isinstance(each, (int, float) if one is float else one) for each in values):
        raise ValueError(f"'{key}' is {value!r}; valid: {one.__name__}")
    if key == "submit" and any("/" in name for name in values):
        raise ValueError("'submit' has names of files, without folders")
    return tuple(values) if is_list else value


def _criterion(name: str, given: Any) -> Criterion:
    if not isinstance(given, dict) or set(given) != {"points", "about"} or not given["points"] > 0:
        raise ValueError(f"criterion '{name}' is none; valid: {{points: 2, about: TEXT}}")
    return Criterion(name, float(given["points"]), str(given["about"]))


def hand_out(exercise: Exercise, folder: Path) -> list[Path]:
    """Write the task sheet, the skeleton and the data; what its reader has changed stays.

    Returns:
        The files that were written.

    Raises:
        ArjunaError: A file cannot be read or written.
    """
    given = {exercise.submit[0]: exercise.skeleton.encode()} if exercise.skeleton else {}
    for name in exercise.data:
        given[Path(name).name] = read_bytes(Path(found_or_shipped(name)), 1 << 26)
    emptied_folder(folder, "README.md")
    written = [folder / "README.md"]
    written[0].write_text(sheet(exercise), encoding="utf-8")
    for name, data in given.items():
        if not (folder / name).exists():
            (folder / name).write_bytes(data)
            written.append(folder / name)
    return written


def sheet(exercise: Exercise) -> str:
    """Return an exercise's task sheet."""
    rows = "".join(f"| {one.about} | {one.points:g} |\n" for one in exercise.criteria)
    return (
        f"# {exercise.title}\n\n{exercise.task.strip()}\n\n"
        f"| criterion | points |\n|---|---|\n{rows}\n{''.join(_rules(exercise))}"
    )


def _rules(exercise: Exercise) -> Iterator[str]:
    yield f"Hand in `{'`, `'.join(exercise.submit)}`; `python -m bringup grade .` says your points."
    if exercise.function:
        yield "\nThe functions alone are called: nothing of ROS is needed.\n"
    elif exercise.runs:
        received, sent = (
            ", ".join(f"`{topic.split()[0]}`" for topic in topics)
            for topics in (exercise.listen, exercise.publish)
        )
        yield (
            f"\nYour program runs as `ros2 run {exercise.submit[0]}` does, for"
            f" {exercise.duration:g} s of the robot's time.\nIt hears {received}\nand may publish"
            f" {sent}. Time passes in `rclpy.spin`, `spin_once` and `time.sleep` alone: a loop\n"
            "without them never ends.\n"
        )
    else:
        yield "\n"


def files_of(exercise: Exercise, submission: Path) -> dict[str, bytes]:
    """Return a submission's files by name, of a folder or of the one file that is needed.

    Raises:
        SubmissionError: One is missing, leads elsewhere, is too large, or there are too many.
    """
    folder = submission if submission.is_dir() else submission.parent
    if not submission.is_dir():
        found = {exercise.submit[0]: submission}
        found |= {name: folder / name for name in exercise.submit[1:]}
    else:
        found = {path.name: path for path in sorted(folder.iterdir()) if _counts(path)}
    if missing := [name for name in exercise.submit if name not in found]:
        raise SubmissionError(folder, f"has no {', '.join(missing)}, which is to be handed in")
    if len(found) > _MANY:
        raise SubmissionError(folder, f"has {len(found)} files; at most {_MANY} are taken")
    if away := [n for n, p in found.items() if p.resolve().parent != folder.resolve()]:
        raise SubmissionError(folder, f"{away[0]} leads to another folder; hand in the file itself")
    return {name: read_bytes(path, _LARGEST, SubmissionError) for name, path in found.items()}


def _counts(path: Path) -> bool:
    """Return whether a file is handed in; what Python and editors leave is not."""
    return not path.is_dir() and not path.name.startswith(".") and path.name != "README.md"
