"""Tests of launch files as people write them: the file is imported, and its actions looked into."""

from __future__ import annotations

import importlib
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from launch import LaunchContext, utilities
from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    ExecuteLocal,
    GroupAction,
    IncludeLaunchDescription,
    LogInfo,
    OpaqueFunction,
    RegisterEventHandler,
    SetEnvironmentVariable,
    Shutdown,
    TimerAction,
)
from launch.conditions import IfCondition
from launch.event_handlers import OnProcessExit
from launch.events.process import ProcessExited
from launch.launch_description_sources import AnyLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch.utilities import perform_substitutions
from launch_ros.actions import (
    ComposableNodeContainer,
    LoadComposableNodes,
    Node,
    PushRosNamespace,
)
from launch_ros.descriptions import ComposableNode
from launch_ros.parameter_descriptions import ParameterFile, ParameterValue
from launch_ros.substitutions import FindPackageShare
from launch_ros.utilities import evaluate_parameters

from arjuna_core.files.shipped import shipped_file


def _node() -> Any:
    file = PathJoinSubstitution([FindPackageShare("not_here"), "config", "a.yaml"])
    return Node(
        package="a_package",
        executable="a_node",
        name="one",
        output="both",
        prefix="nice",
        emulate_tty=True,
        respawn=True,
        respawn_delay=1.5,
        sigterm_timeout="10",
        on_exit=Shutdown(reason="it has ended"),
        arguments=["--fast"],
        remappings=[("scan", LaunchConfiguration("scan_topic"))],
        parameters=[
            {
                "use_sim_time": LaunchConfiguration("sim"),
                "a": {"b": [1, 2.5]},
                "c": ParameterValue(LaunchConfiguration("c"), value_type=float),
            },
            ParameterFile(file),
        ],
        condition=IfCondition(LaunchConfiguration("wanted")),
    )


def _context(**configurations: str) -> LaunchContext:
    context = LaunchContext()
    context.launch_configurations.update(configurations)
    return context


def test_parameters_of_a_node_are_evaluated_without_starting_it() -> None:
    node, context = _node(), _context(sim="true", c="3")
    values, file = node._Node__parameters
    assert evaluate_parameters(context, [values]) == (
        {"use_sim_time": True, "a.b": (1.0, 2.5), "c": 3.0},
    )
    assert [str(part) for part in file.param_file[0].substitutions[1:]] == ["config", "a.yaml"]
    other: Any = Node(executable="e", parameters=["/p.yaml"])
    assert evaluate_parameters(context, other._Node__parameters) == (Path("/p.yaml"),)


def test_what_a_node_was_given_has_the_originals_names() -> None:
    assert isinstance(_node(), ExecuteLocal)
    node, context = _node(), _context(scan_topic="/s", wanted="false")
    assert (node._Node__package, node._Node__node_executable) == ("a_package", "a_node")
    assert (vars(node)["_Node__node_name"], node._Node__arguments) == ("one", ["--fast"])
    pairs = [
        tuple(perform_substitutions(context, one) for one in p) for p in node._Node__remappings
    ]
    assert pairs == [("scan", "/s")]
    assert (node._ExecuteLocal__respawn, node._ExecuteLocal__respawn_delay) == (True, 1.5)
    assert node._ExecuteLocal__sigterm_timeout[0].text == "10"
    assert node._ExecuteLocal__emulate_tty
    assert perform_substitutions(context, node._ExecuteLocal__output) == "both"
    described = node._ExecuteLocal__process_description
    assert perform_substitutions(context, described._Executable__prefix) == "nice"
    assert node._ExecuteLocal__on_exit._EmitEvent__event._Shutdown__reason == "it has ended"
    assert isinstance(node._ExecuteLocal__on_exit, EmitEvent)
    assert node._Action__condition.evaluate(context) is False


def test_what_other_actions_were_given_has_the_originals_names() -> None:
    node, said = _node(), LogInfo(msg="x")
    group: Any = GroupAction([PushRosNamespace("a"), node])
    assert (group._GroupAction__actions[1], group._GroupAction__scoped) == (node, True)
    assert node in group.get_sub_entities()
    timer: Any = TimerAction(period=2.0, actions=[said])
    assert (timer._TimerAction__period, timer._TimerAction__actions) == (2.0, [said])
    variable: Any = SetEnvironmentVariable("NAME", "value")
    names = (variable._SetEnvironmentVariable__name, variable._SetEnvironmentVariable__value)
    assert [one[0].text for one in names] == ["NAME", "value"]
    include: Any = IncludeLaunchDescription("/a.launch.py", launch_arguments={"x": "1"}.items())
    assert dict(vars(include)["_IncludeLaunchDescription__launch_arguments"]) == {"x": "1"}
    source = include._IncludeLaunchDescription__launch_description_source
    assert source._LaunchDescriptionSource__location[0]._TextSubstitution__text == "/a.launch.py"
    argument: Any = DeclareLaunchArgument("a", default_value=LaunchConfiguration("b"))
    (default,) = argument._DeclareLaunchArgument__default_value
    assert default._LaunchConfiguration__variable_name[0].text == "b"
    called: Any = OpaqueFunction(function=_context)
    assert called._OpaqueFunction__function is _context


def test_containers_say_their_nodes() -> None:
    given = ComposableNode(package="p", plugin="p::N", name="one", remappings=[("a", "b")])
    load: Any = LoadComposableNodes(composable_node_descriptions=[given], target_container="c")
    container: Any = ComposableNodeContainer(composable_node_descriptions=[given])
    (one,) = load._LoadComposableNodes__composable_node_descriptions
    assert container._ComposableNodeContainer__composable_node_descriptions == [one]
    assert load._LoadComposableNodes__target_container == "c"
    assert (one.node_plugin, one.node_name) == ("p::N", "one")
    assert (one._ComposableNode__package, one._ComposableNode__node_plugin) == ("p", "p::N")


def test_conditions_and_sources_say_what_they_were_given() -> None:
    condition: Any = IfCondition(LaunchConfiguration("a"))
    (expression,) = condition._IfCondition__predicate_expression
    assert str(expression) == "LaunchConfiguration([TextSubstitution(a)], None)"
    pushed: Any = PushRosNamespace("robot")
    assert pushed._PushROSNamespace__namespace[0].text == "robot"
    file = shipped_file("tests/foreign/launch/files/opaque.launch.py")
    source = AnyLaunchDescriptionSource(str(file))
    assert source.try_get_launch_description_without_context().entities


def test_handlers_are_asked_for_what_they_do() -> None:
    node, said = _node(), LogInfo(msg="x")
    registered: Any = RegisterEventHandler(OnProcessExit(target_action=node, on_exit=[said]))
    handler = registered._RegisterEventHandler__event_handler
    assert handler._OnActionEventBase__actions_on_event == [said]
    ended = ProcessExited(action=node, name="one", cmd=[], cwd=None, env=None, pid=1, returncode=0)
    assert handler.matches(ended)
    assert handler.handle(ended, LaunchContext()) == [said]


def test_a_launch_file_that_is_imported_finds_packages_in_any_program() -> None:
    looks = "import launch; from ament_index_python import get_package_share_directory as f;"
    code = f"{looks} print(f('nav2_bringup'))"
    found = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60.0
    )
    assert found.stdout.strip().endswith("share/nav2_bringup"), found.stderr


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("true", bool, True),
        ("3", float, 3.0),
        ("3", str, "3"),
        ("[1, 2.5]", list[float], [1.0, 2.5]),
        ("['a']", None, ["a"]),
    ],
)
def test_substitutions_become_values_of_a_type(text: str, kind: Any, value: Any) -> None:
    assert importlib.import_module("launch.utilities.type_utils") is utilities
    given = utilities.normalize_typed_substitution(LaunchConfiguration("a"), kind)
    found = utilities.perform_typed_substitution(_context(a=text), given, kind)
    assert (type(found), found) == (type(value), value)
    assert utilities.perform_typed_substitution(_context(), value, kind) == value


@pytest.mark.parametrize(("text", "kind"), [("x", bool), ("1.5", int), ("3", list[int])])
def test_what_is_of_another_type_is_refused(text: str, kind: Any) -> None:
    with pytest.raises(ValueError, match=f"'{text}' is no {kind.__name__}"):
        utilities.coerce_to_type(text, kind)
