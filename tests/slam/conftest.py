"""A mapped drive through the room, its session and the file of that."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_slam.mapping.session import Session, save_session
from arjuna_slam.slam import Slam
from tests.slam.slam_room import Log, drive


@pytest.fixture(scope="module")
def log() -> Log:
    return drive(seed=5)


@pytest.fixture(scope="module")
def mapped(log: Log) -> Slam:
    slam = Slam()
    for scan, odometry, _ in log:
        slam.process(scan, odometry)
    slam.optimize()
    return slam


@pytest.fixture(scope="module")
def session(mapped: Slam) -> Session:
    found = mapped.session()
    assert found is not None
    return found


@pytest.fixture
def file(session: Session, tmp_path: Path) -> Path:
    path = tmp_path / "room.posegraph"
    save_session(path, session)
    return path
