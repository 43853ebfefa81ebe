"""Claims: rerun gets all that a recording shows, each in its frame and at its time."""

from __future__ import annotations

import re
import select
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rerun as rr

from arjuna_core.errors import InputFileError
from bringup.viewing.rerun.show import Output, OutputError, replay
from tests.bringup.viewing.drives import Drive, drive, grid, header, make, scan, transform
from tests.helpers.processes import wait_until


@pytest.fixture(scope="module", autouse=True)
def _strict() -> Iterator[None]:
    rr.set_strict_mode(True)
    yield
    rr.set_strict_mode(False)


def rows(path: Path) -> dict[str, list[dict[str, Any]]]:
    """Return the rows of each entity of a file."""
    found: dict[str, list[dict[str, Any]]] = defaultdict(list)
    for chunk in rr.chunk.RrdReader(path).stream():
        table = chunk.to_record_batch()
        columns = {name: table.column(name) for name in table.schema.names}
        if "time" in columns:  # nanoseconds, which datetime does not hold
            columns["time"] = columns["time"].cast("int64")
        for number in range(table.num_rows):
            row = {name: column[number].as_py() for name, column in columns.items()}
            found[chunk.entity_path].append(row)
    return found


def values(found: list[dict[str, Any]], component: str) -> list[Any]:
    return [row[component] for row in found if row.get(component) is not None]


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[dict[str, Any]]]:
    folder = tmp_path_factory.mktemp("shown")
    replay(drive(folder / "bag"), folder / "x.rrd", False, lambda line: None)
    return rows(folder / "x.rrd")


def test_frames_move_and_the_robot_with_them(saved: dict[str, list[dict[str, Any]]]) -> None:
    base = saved["/tf/base_link"]
    positions = [position[0][0] for position in values(base, "Transform3D:translation")]
    assert sorted(positions) == pytest.approx([0.05 * step for step in range(20)], abs=1e-6)
    assert {each[0] for each in values(base, "Transform3D:parent_frame")} == {"odom"}
    for link in ("base_link", "wheel"):
        assert values(saved[f"/robot/{link}"], "CoordinateFrame:frame") == [[link]]
        assert values(saved[f"/robot/{link}"], "Asset3D:blob")


def test_scans_are_points_without_the_beams_that_met_nothing(
    saved: dict[str, list[dict[str, Any]]],
) -> None:
    points = values(saved["/scan"], "Points3D:positions")
    assert len(points) == 20
    assert np.shape(points[0]) == (3, 3)
    assert values(saved["/scan"], "CoordinateFrame:frame") == [["base_link"]]


def test_a_map_is_upright_and_lies_where_it_shall(saved: dict[str, list[dict[str, Any]]]) -> None:
    (translation,) = values(saved["/map"], "GridMap:translation")
    assert translation[0][:2] == pytest.approx([-1.05, -1.0])
    (size,) = values(saved["/map"], "GridMap:cell_size")
    assert size == pytest.approx([0.1])


def test_curves_run_over_the_time_of_the_recording(saved: dict[str, list[dict[str, Any]]]) -> None:
    speed = values(saved["/curves/speed/cmd_vel"], "Scalars:scalars")
    assert speed == [[0.5]] * 20
    error = values(saved["/curves/error/position"], "Scalars:scalars")
    assert [each[0] for each in error] == pytest.approx([0.02] * len(error), abs=1e-6)
    times = [row["time"] / 1e9 for row in saved["/curves/speed/cmd_vel"]]
    assert sorted(times) == pytest.approx([step / 10 for step in range(20)])


def test_pictures_particles_paths_and_states_are_there(
    saved: dict[str, list[dict[str, Any]]],
) -> None:
    assert len(values(saved["/camera/image_raw"], "EncodedImage:blob")) == 10  # five a second
    assert np.shape(values(saved["/particle_cloud"], "Arrows3D:origins")[0]) == (2, 3)
    assert np.shape(values(saved["/plan"], "LineStrips3D:strips")[0][0]) == (3, 3)
    assert values(saved["/states/navigate_to_pose"], "StateChange:state") == [["executing"]]
    assert values(saved["/goal_pose"], "Arrows3D:origins")


def test_what_is_damaged_is_noted_and_passed_over(tmp_path: Path) -> None:
    recording = Drive(tmp_path / "bag")
    frames = make("tf2_msgs/msg/TFMessage", transforms=[transform("odom", "base_link", 0.0)])
    recording.say(0.0, "/tf", frames)
    recording.say(0.1, "/scan", scan(0.0), damaged=True)
    wrong = grid()
    wrong.info.width = 7
    recording.say(0.2, "/map", wrong)
    recording.say(0.3, "/scan", scan(0.0))
    said: list[str] = []
    replay(recording.close(), tmp_path / "x.rrd", False, said.append)
    assert any("/map: 620 cells for a grid of 7 x 20" in line for line in said)
    assert any("note: /scan: sensor_msgs/msg/LaserScan: Could" in line for line in said)
    assert len(values(rows(tmp_path / "x.rrd")["/scan"], "Points3D:positions")) == 1


def test_markers_are_the_points_of_all_of_them(tmp_path: Path) -> None:
    def marker(*points: tuple[float, float]) -> Any:
        at = [make("geometry_msgs/msg/Point", x=x, y=y, z=0.0) for x, y in points]
        return make("visualization_msgs/msg/Marker", header=header("odom"), points=at)

    kind, recording = "visualization_msgs/msg/MarkerArray", Drive(tmp_path / "bag")
    markers = [marker((1.0, 2.0), (3.0, 4.0)), marker((5.0, 6.0))]
    recording.say(0.0, "/graph", make(kind, markers=markers))
    recording.say(1.0, "/none", make(kind, markers=[]))
    said: list[str] = []
    replay(recording.close(), tmp_path / "x.rrd", False, said.append)
    (points,) = values(rows(tmp_path / "x.rrd")["/graph"], "Points3D:positions")
    assert [point[1] for point in points] == [2, 4, 6]
    assert "note: /none: it has no marker" in said


def test_no_file_is_overwritten(tmp_path: Path) -> None:
    (tmp_path / "x.rrd").write_text("mine")
    with pytest.raises(OutputError, match="exists already and is not overwritten"):
        replay(drive(tmp_path / "bag"), tmp_path / "x.rrd", False, lambda line: None)
    assert (tmp_path / "x.rrd").read_text() == "mine"


def test_without_a_display_the_alternatives_are_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(OutputError, match=r"valid: --web for a browser, --save FILE\.rrd"):
        replay(drive(tmp_path / "bag"), None, False, lambda line: None)


def test_the_page_and_its_data_are_served_on_loopback_alone() -> None:
    def bound() -> dict[int, str]:
        tables = [Path(f"/proc/net/{name}").read_text(encoding="ascii") for name in ("tcp", "tcp6")]
        rows = [line.split() for table in tables for line in table.splitlines()[1:]]
        listening = (row[1].split(":") for row in rows if row[3] == "0A")
        return {
            number: address for address, port in listening if (number := int(port, 16)) in ports
        }

    said: list[str] = []
    with Output(None, True, said.append):
        ports = {int(port) for port in re.findall(r"(?::|%3A)(\d+)", said[0])}
        wait_until(lambda: len(bound()) == 2, lambda: select.select([], [], [], 0.05), ports)
        assert set(bound().values()) == {"0100007F"}  # 127.0.0.1


def test_a_recording_with_nothing_to_show_is_refused(tmp_path: Path) -> None:
    recording = Drive(tmp_path / "bag")
    recording.say(0.0, "/number", make("std_msgs/msg/Int32", data=7))
    bag = recording.close()
    with pytest.raises(InputFileError, match="nothing that can be shown; its topics: /number"):
        replay(bag, tmp_path / "x.rrd", False, lambda line: None)
