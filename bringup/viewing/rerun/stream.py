"""Rows for rerun, gathered into columns: a thousand rows at once cost as much as three alone."""

from __future__ import annotations

from collections import defaultdict
from typing import Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray

TIMELINE = "time"


class Stream:
    """Writes to a rerun recording on one timeline, seconds since its beginning.

    Args:
        patience: How long rows may wait to be sent together [s].
        most: Rows that may wait.
    """

    def __init__(self, recording: rr.RecordingStream, patience: float, most: int = 4000) -> None:
        self.recording = recording
        self._patience, self._most = patience, most
        self._start: int | None = None
        self._sent = 0.0
        self._waiting = 0
        self.now = 0.0
        self._frames: dict[str, str] = {}
        self._transforms: dict[str, list[tuple[Any, ...]]] = defaultdict(list)
        self._scalars: dict[str, list[tuple[float, float]]] = defaultdict(list)
        self._clouds: dict[str, list[tuple[float, NDArray[np.float32]]]] = defaultdict(list)

    def at(self, time: int) -> None:
        """Move on to a time [ns]; the first one given is the beginning."""
        self._start = time if self._start is None else self._start
        self.now = (time - self._start) / 1e9
        if self._waiting >= self._most or abs(self.now - self._sent) >= self._patience:
            self.flush()

    def log(self, entity: str, *archetypes: Any) -> None:
        """Log something as of now."""
        self.recording.set_time(TIMELINE, duration=self.now)
        self.recording.log(entity, *archetypes)

    def always(self, entity: str, *archetypes: Any) -> None:
        """Log something that holds for all time."""
        self.recording.log(entity, *archetypes, static=True)

    def set_frame(self, entity: str, frame: str) -> bool:
        """Say in which frame an entity is; return whether that is new."""
        if self._frames.get(entity) == frame:
            return False
        self._frames[entity] = frame
        if frame:
            self.always(entity, rr.CoordinateFrame(frame))
        return True

    def transform(
        self,
        parent: str,
        child: str,
        translation: tuple[float, float, float],
        quaternion: tuple[float, float, float, float],
    ) -> None:
        """Add `T_parent_child` as of now; translation [m], quaternion x, y, z, w."""
        self._transforms[child].append((self.now, parent, translation, quaternion))
        self._waiting += 1

    def scalar(self, entity: str, value: float) -> None:
        """Add a value of a curve as of now."""
        self._scalars[entity].append((self.now, value))
        self._waiting += 1

    def cloud(self, entity: str, points: NDArray[np.float32]) -> None:
        """Add points `(N, 3) float32` [m] as of now, in place of those before."""
        self._clouds[entity].append((self.now, points))
        self._waiting += 1

    def flush(self) -> None:
        """Send what waits."""
        for child, rows in self._transforms.items():
            self._send_transforms(child, rows)
        for entity, values in self._scalars.items():
            times, numbers = zip(*values, strict=True)
            self._send(entity, times, rr.Scalars.columns(scalars=np.array(numbers)))
        for entity, clouds in self._clouds.items():
            points = np.concatenate([each for _, each in clouds])
            lengths = [len(each) for _, each in clouds]
            columns = rr.Points3D.columns(positions=points).partition(lengths)
            self._send(entity, [time for time, _ in clouds], columns)
        self._transforms.clear()
        self._scalars.clear()
        self._clouds.clear()
        self._waiting, self._sent = 0, self.now

    def _send_transforms(self, child: str, rows: list[tuple[Any, ...]]) -> None:
        times, parents, translations, quaternions = zip(*rows, strict=True)
        columns = rr.Transform3D.columns(
            translation=np.array(translations, dtype=np.float32),
            quaternion=np.array(quaternions, dtype=np.float32),
            parent_frame=parents,
            child_frame=[child] * len(rows),
        )
        self._send(f"tf/{child}", times, columns)

    def _send(self, entity: str, times: Any, columns: Any) -> None:
        index = rr.TimeColumn(TIMELINE, duration=np.asarray(times, dtype=np.float64))
        self.recording.send_columns(entity, [index], columns)
