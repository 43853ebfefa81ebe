"""Stock parameter files load as they are; what others know is noted, what nobody knows is named."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from arjuna_core.config import load
from arjuna_core.errors import InputFileError
from arjuna_nav.costmap import CostmapConfig
from bringup.cli import parse
from bringup.parameters.checking import check_file
from bringup.parameters.files import Parameters, load_parameters, shipped_parameters
from bringup.parameters.foreign.understanding import understand
from bringup.parameters.inputs import gather
from bringup.parameters.remarks import Checked, lines
from bringup.stack import all_nodes, further_nodes
from tests.helpers.files import written
from tests.helpers.nav.stock_files import FILES, humble_file, nav2_file

pytestmark = pytest.mark.ros
NAV2: dict[str, Any] = yaml.safe_load(
    (Path(__file__).parent / "nav2_files.yaml").read_text(encoding="utf-8")
)


def understood(folder: Path, text: str) -> Checked:
    given = load_parameters([written(folder, text)])
    return understand(given, shipped_parameters(), [*all_nodes(), *further_nodes(given)])


@pytest.mark.parametrize("name", FILES)
def test_a_stock_file_loads_unchanged(name: str, tmp_path: Path) -> None:
    assert check_file(written(tmp_path, FILES[name])).problems == []


def test_effectless_parameters_count(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    later = "    FollowPath.TrajectoryValidator.consider_footprint: true\n"  # of Nav2 after Jazzy
    plain = "planner_server:\n"
    path = written(tmp_path, nav2_file().replace(plain, later + plain))
    gather(parse(["demo", "--params", str(path)]))
    *safety, no_effect, not_needed = capsys.readouterr().err.splitlines()
    of_file = re.compile(rf"{path}:\d+: no effect yet \(SAFETY\): |unlike the robot \(SAFETY\): ")
    assert all(of_file.match(line) for line in safety)
    listing = "names; 'params check -v FILE' lists them"
    assert re.fullmatch(rf"no effect yet: \d+ {listing}", no_effect)
    assert not_needed.startswith("not needed here: ")
    listed = "\n".join(lines(check_file(path).remarks))
    assert "not needed here: loopback_simulator: there is no such node here: the simu" in listed
    assert "'static_layer' is in no list of plug-ins" in listed


def test_what_has_another_name_here_is_used(tmp_path: Path) -> None:
    parameters = understood(tmp_path, humble_file()).parameters
    controller, local = parameters["controller_server"], parameters["local_costmap/local_costmap"]
    assert controller["progress_checker_plugins"] == ["moves"]
    assert controller["moves.plugin"] == "nav2_controller::SimpleProgressChecker"
    assert local["plugins"] == ["voxel_layer", "inflation_layer"]
    assert local["voxel_layer.scan.obstacle_max_range"] == 2.5
    assert parameters["collision_monitor"]["scan.topic"] == "scan"


@pytest.mark.parametrize("name", NAV2)
def test_a_file_of_nav2_means_here_what_it_means_there(name: str, tmp_path: Path) -> None:
    text = NAV2[name]["text"]
    assert check_file(written(tmp_path, text)).problems == []
    found = understood(tmp_path, text)
    for node, values in NAV2[name]["becomes"].items():
        assert {key: found.parameters[node][key] for key in values} == values
    assert len(found.remarks) == NAV2[name].get("remarks", len(found.remarks))
    said = "\n".join(map(str, found.remarks))
    assert [reason for reason in NAV2[name].get("reasons", ()) if reason not in said] == []


def test_nothing_is_kept_of_a_plugin_that_the_file_replaces(tmp_path: Path) -> None:
    assert "FollowPath.desired_linear_vel" in shipped_parameters()["controller_server"]
    text = "controller_server: {ros__parameters: {controller_plugins: [Other]}}"
    kept = understood(tmp_path, text).parameters["controller_server"]
    assert not [key for key in kept if key.startswith("FollowPath.")]


def test_a_layer_of_no_class_is_named(tmp_path: Path) -> None:
    text = "local_costmap: {local_costmap: {ros__parameters: {plugins: [obstacle_layr]}}}"
    (problem,) = check_file(written(tmp_path, text)).problems
    assert "'obstacle_layr.plugin' must name the class of the layer; did you mean" in problem


def test_a_map_that_nobody_has_is_a_note(tmp_path: Path) -> None:
    path = written(tmp_path, "map_server: {ros__parameters: {yaml_filename: /no/map.yaml}}")
    assert check_file(path).problems == []
    assert [str(remark) for remark in check_file(path).remarks] == [
        "no effect yet: map_server: yaml_filename: there is no /no/map.yaml; 'nav --map FILE' takes"
        " its place"
    ]


@pytest.mark.parametrize(
    ("node", "key"), [("docking_server", "dock_database"), ("route_server", "graph_filepath")]
)
@pytest.mark.parametrize("name", ["/no/file", "$(find-pkg-share mine)/config/file"])
def test_files_of_docks_and_routes_that_nobody_has_are_left_out(
    node: str, key: str, name: str, tmp_path: Path
) -> None:
    found = check_file(written(tmp_path, f"{node}: {{ros__parameters: {{{key}: {name}}}}}"))
    assert found.problems == []
    (remark,) = found.remarks
    assert f"no effect yet: {node}: {key}: there is no {name}: no" in str(remark)
    assert key not in found.parameters[node]


def lattice(drive: str) -> str:
    folder = "nav2_smac_planner/sample_primitives/5cm_resolution/1m_turning_radius"
    one = f"plugin: nav2_smac_planner/SmacPlannerLattice, lattice_filepath: /no/{folder}/{drive}/a"
    return f"planner_server: {{ros__parameters: {{planner_plugins: [A], A: {{{one}}}}}}}"


def test_a_lattice_of_nav2_bends_by_its_radius(tmp_path: Path) -> None:
    found = check_file(written(tmp_path, lattice("diff")))
    assert found.problems == []
    assert "bend by 1 m, and turns on the spot, take its place" in str(found.remarks)
    assert found.parameters["planner_server"]["A.minimum_turning_radius"] == 1.0


def test_a_lattice_of_a_car_has_nothing_in_its_place(tmp_path: Path) -> None:
    (problem,) = check_file(written(tmp_path, lattice("ackermann"))).problems
    assert "SmacPlannerHybrid plans for cars" in problem


@pytest.mark.parametrize("name", ["FILLED_AT_LAUNCH", "see the launch file", "/no/tree.xml"])
def test_a_tree_that_nobody_has_leaves_the_default_one(name: str, tmp_path: Path) -> None:
    key = "default_nav_to_pose_bt_xml"
    path = written(tmp_path, f"bt_navigator: {{ros__parameters: {{{key}: {name}}}}}")
    found = check_file(path)
    assert found.problems == []
    (remark,) = found.remarks
    assert f"unknown: bt_navigator: {key}: there is no behavior tree '{name}'; the" in str(remark)
    assert key not in found.parameters["bt_navigator"]


OWN_NODE = "<Fallback><MyDoor/><Wait/></Fallback>"


@pytest.mark.parametrize(
    ("tree", "libraries", "refused"),
    [
        (OWN_NODE, "[nav2_wait_action_bt_node, my_door_bt_node]", False),
        (OWN_NODE, "[nav2_wait_action_bt_node]", True),
        ("<Wait duration='5'/>", "[my_door_bt_node]", True),
    ],
)
def test_a_tree_with_nodes_of_someone_s_c_leaves_the_default_one(
    tree: str, libraries: str, refused: bool, tmp_path: Path
) -> None:
    (own := tmp_path / "own.xml").write_text(
        f"<root BTCPP_format='4'><BehaviorTree ID='M'>{tree}</BehaviorTree></root>"
    )
    key = "default_nav_to_pose_bt_xml"
    text = f"{{{key}: {own}, plugin_lib_names: {libraries}}}"
    found = check_file(written(tmp_path, f"bt_navigator: {{ros__parameters: {text}}}"))
    said = [*found.problems, *map(str, found.remarks)]
    assert len(said) == 1
    assert f"bt_navigator: {key}: {own}: " in said[0]
    assert bool(found.problems) == (key in found.parameters["bt_navigator"]) == refused


SHORT = "behavior_server: {ros__parameters: {behavior_plugins: [wait, backup]}}\n"
NAMED = "navigate_to_pose_w_replanning_and_recovery.xml"


def test_what_the_tree_calls_and_a_server_leaves_out_is_told_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path, SHORT)
    reason = "<Spin> of navigate_to_pose.xml calls 'spin', which it leaves out (wait, backup)"
    (remark,) = check_file(path).remarks
    assert f"{path}:1: unknown: behavior_server: behavior_plugins: {reason}: that" in str(remark)
    gather(parse(["nav", "--map", "maps/arjuna_room.yaml", "--params", str(path)]))
    assert capsys.readouterr().err.count(f"behavior_server: behavior_plugins: {reason}") == 1


@pytest.mark.parametrize(
    ("node", "lists", "name"),
    [
        ("planner_server", "{planner_plugins: [A, B]}", "GridBased"),
        ("controller_server", "{controller_plugins: [A, B]}", "FollowPath"),
    ],
)
def test_a_plug_in_that_the_tree_names_is_in_its_server_s_list(
    node: str, lists: str, name: str, tmp_path: Path
) -> None:
    text = f"bt_navigator: {{ros__parameters: {{default_nav_to_pose_bt_xml: {NAMED}}}}}\n"
    assert check_file(written(tmp_path, text)).remarks == []
    found = check_file(written(tmp_path, f"{text}{node}: {{ros__parameters: {lists}}}"))
    (said,) = [str(one) for one in found.remarks if "leaves out" in str(one)]
    assert f"{node}: {node.removesuffix('_server')}_plugins: <" in said
    assert f"of {NAMED} calls '{name}', which it leaves out (A, B): that fails, as in Nav2" in said


def test_a_tree_s_server_that_the_blackboard_names_is_not_looked_for(tmp_path: Path) -> None:
    calls = "<Fallback><Spin server_name='{mine}'/><Wait/><Wait server_name='rest'/></Fallback>"
    (own := tmp_path / "own.xml").write_text(
        f"<root BTCPP_format='4'><BehaviorTree ID='M'>{calls}</BehaviorTree></root>"
    )
    keys = ", ".join(f"default_nav_{kind}_bt_xml: {own}" for kind in ("to_pose", "through_poses"))
    text = f"{SHORT}bt_navigator: {{ros__parameters: {{{keys}}}}}"
    (remark,) = check_file(written(tmp_path, text)).remarks
    assert f"<Wait> of {own} calls 'rest', which it leaves out (wait, backup)" in str(remark)


@pytest.mark.parametrize("folder", ["/opt/somewhere/", "$(find-pkg-share nav2_bt_navigator)/"])
def test_a_tree_of_nav2_s_is_known_by_its_name(folder: str, tmp_path: Path) -> None:
    name = f"{folder}navigate_to_pose_w_replanning_and_recovery.xml"
    text = f'bt_navigator: {{ros__parameters: {{default_nav_to_pose_bt_xml: "{name}"}}}}'
    assert check_file(written(tmp_path, text)).remarks == []


def test_a_lattice_that_nobody_has_is_refused_before_anything_starts(tmp_path: Path) -> None:
    lattice = "plugin: nav2_smac_planner/SmacPlannerLattice, lattice_filepath: /no/output.json"
    path = written(tmp_path, f"planner_server: {{ros__parameters: {{GridBased: {{{lattice}}}}}}}")
    (problem,) = check_file(path).problems
    assert "planner_server: /no/output.json: there is no such file of lattice" in problem
    with pytest.raises(InputFileError, match="without lattice_filepath, pieces bend by"):
        gather(parse(["demo", "--params", str(path)]))


def test_the_demo_makes_its_own_map(tmp_path: Path) -> None:
    path = written(tmp_path, "map_server: {ros__parameters: {yaml_filename: /no/map.yaml}}")
    assert gather(parse(["demo", "--params", str(path)]))["map_server"]["yaml_filename"] == ""


def test_a_file_of_ros1_is_distinguished(tmp_path: Path) -> None:
    (problem,) = check_file(written(tmp_path, "maxUrange: 3.0")).problems
    assert "params convert FILE" in problem


TWO_LAYERS = """
local_costmap: {local_costmap: {ros__parameters: {plugins: [flat, deep, grown],
  flat: {plugin: "nav2_costmap_2d::VoxelLayer", enabled: true, observation_sources: scan rear,
    scan: {topic: /front, data_type: LaserScan}, rear: {topic: /rear, data_type: LaserScan}},
  deep: {plugin: "nav2_costmap_2d::VoxelLayer", enabled: true, observation_sources: left right,
    left: {topic: /left/points, data_type: PointCloud2, max_obstacle_height: 1.2},
    right: {topic: /right/points, data_type: PointCloud2}},
  grown: {plugin: "nav2_costmap_2d::InflationLayer"}}}}
"""


def test_two_layers_of_a_kind_keep_their_sources(tmp_path: Path) -> None:
    assert check_file(written(tmp_path, TWO_LAYERS)).problems == []
    values = understood(tmp_path, TWO_LAYERS).parameters["local_costmap/local_costmap"]
    config = load(CostmapConfig, values)
    assert config.plugins == ("flat", "deep", "grown")
    assert config.scan_topics == {"flat.scan.topic": "/front", "flat.rear.topic": "/rear"}
    assert values["deep.left.topic"] == "/left/points"
    assert values["deep.left.max_obstacle_height"] == 1.2


def test_a_layer_of_others_is_one_note(tmp_path: Path) -> None:
    theirs = "somebodys_layers/DepthLayer"
    text = f"""
local_costmap: {{local_costmap: {{ros__parameters: {{plugins: [mine, inflation_layer],
  mine: {{plugin: "{theirs}", enabled: true, depth: {{topic: /points, fov: 0.8}}}}}}}}}}
"""
    found = understood(tmp_path, text)
    assert found.problems == check_file(written(tmp_path, text)).problems == []
    (remark,) = found.remarks
    assert remark.safety
    assert f"'{theirs.replace('/', '::')}' is someone's C++" in remark.reason
    assert found.parameters["local_costmap/local_costmap"]["plugins"] == ["inflation_layer"]


@pytest.mark.parametrize("wrong", ["nav2_costmap_2d::ObstacleLayr", "nav2_costmap2d/ObstacleLayer"])
def test_a_layer_of_a_class_that_nobody_knows_is_named(wrong: str, tmp_path: Path) -> None:
    text = f"""
local_costmap: {{local_costmap: {{ros__parameters: {{plugins: [mine, inflation_layer],
  mine: {{plugin: "{wrong}", observation_sources: scan}}}}}}}}
"""
    (problem,) = check_file(written(tmp_path, text)).problems
    assert "'mine.plugin': no layer '" in problem
    assert "did you mean 'nav2_costmap_2d::ObstacleLayer'?" in problem


def misspelt(document: dict[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """Return a file in which each node has one key with two letters swapped."""
    wrong = []
    for content in document.values():
        inner = content
        while "ros__parameters" not in inner:
            inner = next(iter(inner.values()))
        values = inner["ros__parameters"]
        key = next(k for k in values if not isinstance(values[k], dict) and len(k) > 9)
        bad = key[:4] + key[5] + key[4] + key[6:]
        if bad != key:
            values[bad] = values.pop(key)
            wrong.append(bad)
    return document, wrong


def test_all_mistakes_of_all_nodes_are_named_at_once(tmp_path: Path) -> None:
    document = yaml.safe_load(nav2_file())
    document, wrong = misspelt(
        {name: document[name] for name in ("amcl", "bt_navigator", "controller_server")}
    )
    problems = check_file(written(tmp_path, yaml.safe_dump(document))).refused_by(strict=True)
    assert len(wrong) >= 3
    for key in wrong:
        assert any(f"{key}: no such parameter; the nearest" in one for one in problems), problems


EVERYWHERE: list[tuple[str, Parameters | str]] = [
    ("{transform_tolerance: 0.4, use_sim_time: true}", "amcl"),
    ("{bond_heartbeat_period: 0.2}", ""),
]


@pytest.mark.parametrize(("values", "taker"), EVERYWHERE)
def test_wildcards_reach_nodes_with_the_name(values: str, taker: str, tmp_path: Path) -> None:
    found = understood(tmp_path, f"/**: {{ros__parameters: {values}}}")
    changed = {n for n, v in found.parameters.items() if v != shipped_parameters().get(n, {})}
    assert found.problems == []
    assert (taker in changed) == bool(taker)
    assert bool(found.remarks) == (not taker)


def test_a_name_for_every_node_that_none_has_is_named(tmp_path: Path) -> None:
    found = understood(tmp_path, "/**: {ros__parameters: {transform_tolerence: 0.4}}")
    assert [str(remark) for remark in found.remarks] == [
        "unknown: /**: transform_tolerence: no node has it; the nearest is 'transform_tolerance'"
    ]


@pytest.mark.parametrize("suffix", ["", ".posegraph"])
def test_a_graph_that_nobody_has_is_left_out_unless_it_is_asked_for(
    suffix: str, tmp_path: Path
) -> None:
    graph = tmp_path / "room"
    named = f"slam_toolbox: {{ros__parameters: {{map_file_name: {graph}{suffix}}}}}"
    file = written(tmp_path, named)
    found = check_file(file)
    assert "map_file_name" not in found.parameters["slam_toolbox"]
    assert any("room" in str(one) and "a new map is begun" in str(one) for one in found.remarks)
    asked = ["slam", "--param", f"map_file_name:={graph}"]
    assert gather(parse(asked))["slam_toolbox"]["map_file_name"] == str(graph)
    graph.with_suffix(".posegraph").touch()
    assert check_file(file).parameters["slam_toolbox"]["map_file_name"] == f"{graph}{suffix}"


def test_a_tree_of_before_humble_is_the_one_that_runs(tmp_path: Path) -> None:
    def tree(name: str) -> tuple[str, list[str]]:
        text = f"bt_navigator: {{ros__parameters: {{default_bt_xml_filename: {name}}}}}"
        found = check_file(written(tmp_path, text))
        ran = found.parameters["bt_navigator"].get("default_nav_to_pose_bt_xml", "")
        return ran, [str(one) for one in found.remarks]

    own = tmp_path / "own.xml"
    own.write_text('<root><BehaviorTree ID="T"><Wait/></BehaviorTree></root>', encoding="utf-8")
    assert tree(str(own)) == (str(own), [])
    assert tree("navigate_w_replanning_and_recovery.xml") == ("", [])
    ran, (said,) = tree("/none.xml")
    assert not ran
    assert "there is no behavior tree '/none.xml'; the default one runs" in said
