"""`launch` with real processes: events, ends, output, scopes, and what is left behind: nothing."""

from __future__ import annotations

import asyncio
import gc
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from launch import Action, LaunchContext, LaunchDescription, LaunchService
from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    ExecuteProcess,
    GroupAction,
    IncludeLaunchDescription,
    LogInfo,
    OpaqueCoroutine,
    OpaqueFunction,
    RegisterEventHandler,
    SetEnvironmentVariable,
    SetLaunchConfiguration,
    Shutdown,
    TimerAction,
    UnsetEnvironmentVariable,
)
from launch.conditions import IfCondition
from launch.event_handlers import (
    OnExecutionComplete,
    OnProcessExit,
    OnProcessIO,
    OnProcessStart,
    OnShutdown,
)
from launch.events import matches_action
from launch.events.process import ShutdownProcess, SignalProcess
from launch.frontend import expose_substitution, parse_substitution
from launch.launch_description_source import description_of
from launch.substitution import Substitution, perform_substitutions
from launch.substitutions import (
    Command,
    EnvironmentVariable,
    FileContent,
    LaunchConfiguration,
    PathJoinSubstitution,
    PythonExpression,
    SubstitutionFailure,
)
from launch.texts import InvalidLaunchFileError
from launch_ros import lifecycle
from launch_ros.actions import LifecycleTransition, Node
from launch_ros.parameter_descriptions import ParameterValue, value_of
from launch_ros.utilities import evaluate_parameters
from nav2_common.launch import RewrittenYaml

_FOREVER = ["sleep", "60"]


Launch = Callable[..., tuple[int, str]]


@pytest.fixture
def launched(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> Launch:
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))

    def run(*actions: Any) -> tuple[int, str]:
        service = LaunchService()
        service.include_launch_description(LaunchDescription(actions))
        code = service.run()
        given = capfd.readouterr()
        return code, given.out + given.err

    return run


def test_events_of_a_process_are_in_order(launched: Launch) -> None:
    talker = ExecuteProcess(cmd=["echo", "hello"], output="screen", name="talker")
    said: list[str] = []
    code, printed = launched(
        DeclareLaunchArgument("who", default_value="me"),
        RegisterEventHandler(OnProcessStart(target_action=talker, on_start=[LogInfo(msg="up")])),
        RegisterEventHandler(
            OnProcessIO(target_action=talker, on_stdout=lambda e: said.append(e.text.decode()))
        ),
        RegisterEventHandler(
            OnProcessExit(
                target_action=talker,
                on_exit=lambda event, context: [
                    LogInfo(msg=[LaunchConfiguration("who"), f" ended {event.returncode}"])
                ],
            )
        ),
        RegisterEventHandler(OnShutdown(on_shutdown=[LogInfo(msg="bye")])),
        talker,
    )
    assert (code, said) == (0, ["hello\n"])
    name = talker.process_details["name"]
    order = ["up", f"[{name}] hello", f"[{name}]: process has finished cleanly", "me ended 0"]
    places = [printed.index(text) for text in [*order, "bye"]]
    assert places == sorted(places)


def test_every_action_says_when_it_is_done(launched: Launch) -> None:
    one, two = LogInfo(msg="one"), TimerAction(period=0.3, actions=[LogInfo(msg="two")])
    left_out = LogInfo(msg="three", condition=IfCondition("false"))
    done = [
        RegisterEventHandler(OnExecutionComplete(target_action=action, on_completion=[said]))
        for action, said in (
            (one, LogInfo(msg="after one")),
            (two, LogInfo(msg="after two")),
            (left_out, LogInfo(msg="after three")),
        )
    ]
    said = launched(*done, two, one, left_out)[1]
    order = [said.index(text) for text in ("one", "after one", "two", "after two")]
    assert order == sorted(order)
    assert "three" not in said


def test_output_goes_where_it_is_asked_to(
    launched: Launch, monkeypatch: pytest.MonkeyPatch
) -> None:
    both = ["bash", "-c", "echo out; echo err >&2"]
    shown = {}
    for output in ("screen", "log", "own_log", {"stdout": "screen", "stderr": "log"}):
        _, printed = launched(ExecuteProcess(cmd=both, output=output))
        shown[str(output)] = ("] out" in printed, "] err" in printed)
    assert list(shown.values()) == [(True, True), (False, True), (False, False), (True, False)]
    code, printed = launched(ExecuteProcess(cmd=both, output="scren"))
    assert (code, "valid: screen, both" in printed) == (1, True)


def test_a_required_processs_end_ends_all(launched: Launch) -> None:
    needed = ExecuteProcess(cmd=["sh", "-c", "exit 3"], on_exit=Shutdown(reason="no"), name="core")
    other = ExecuteProcess(cmd=_FOREVER)
    code, printed = launched(other, needed)
    assert "process has died [pid " in printed
    assert "exit code 3" in printed
    assert "was required: shutting down" in printed
    assert (code, other.return_code) == (0, -signal.SIGINT)


def test_an_end_that_no_process_s_end_asks_for_blames_none(launched: Launch) -> None:
    done, other = ExecuteProcess(cmd=["true"]), ExecuteProcess(cmd=_FOREVER)
    noted = RegisterEventHandler(OnProcessExit(target_action=done, on_exit=[LogInfo(msg="done")]))
    code, printed = launched(
        other, noted, done, TimerAction(period=0.5, actions=[Shutdown(reason="time is up")])
    )
    assert (code, "done" in printed, "was required" in printed) == (0, True, False)


def test_an_end_that_asks_for_all_to_end_hurries_none(launched: Launch) -> None:
    loop = "trap 'sleep 0.5; exit 0' INT; echo up; while :; do sleep 0.1; done"
    slow = ExecuteProcess(cmd=["bash", "-c", loop])
    both = [ExecuteProcess(cmd=_FOREVER, on_exit=Shutdown()) for _ in range(2)]
    end = OnProcessIO(target_action=slow, on_stdout=lambda event: Shutdown())
    launched(RegisterEventHandler(end), *both, slow)
    assert slow.return_code == 0


def test_a_process_that_stays_is_ended_by_force(launched: Launch) -> None:
    deaf = ExecuteProcess(
        cmd=["bash", "-c", "trap '' INT TERM; echo deaf; sleep 30 & wait; wait"],
        sigterm_timeout="0.1",
        sigkill_timeout=0.1,
    )
    code, printed = launched(
        RegisterEventHandler(OnProcessIO(target_action=deaf, on_stdout=lambda e: Shutdown())), deaf
    )
    assert (code, deaf.return_code) == (0, -signal.SIGKILL)
    assert "failed to terminate: 'SIGTERM' follows" in printed


@pytest.mark.parametrize(
    ("event", "number"),
    [
        (lambda a: SignalProcess(signal_number="SIGTERM", process_matcher=a), signal.SIGTERM),
        (lambda a: ShutdownProcess(process_matcher=a), signal.SIGINT),
    ],
)
def test_one_process_is_ended_by_an_event(event: Any, number: int, launched: Launch) -> None:
    one = ExecuteProcess(cmd=_FOREVER)
    ends = EmitEvent(event=event(matches_action(one)))
    code, _ = launched(
        one, RegisterEventHandler(OnProcessStart(target_action=one, on_start=[ends]))
    )
    assert (code, one.return_code) == (0, -number)


def test_a_process_respawns_as_often_as_it_may(launched: Launch) -> None:
    again = ExecuteProcess(cmd=["true"], respawn="True", respawn_max_retries=2)
    _, printed = launched(again)
    assert printed.count("process started with pid") == 3


def test_a_missing_program_is_named(launched: Launch) -> None:
    code, printed = launched(
        ExecuteProcess(cmd=["no_such_program"]), ExecuteProcess(cmd=["echo", "x"], output="screen")
    )
    assert code == 1
    assert "cannot be started: [Errno 2]" in printed
    assert "] x\n" in printed


def test_a_program_knows_the_nodes_before_it(
    launched: Launch, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ARJUNA_LAUNCHED", "1")
    first = Node(executable="true", namespace="/a")
    second = Node(executable="printenv", arguments=["ARJUNA_LAUNCHED"], output="screen")
    assert "1 /a/true /printenv\n" in launched(first, second)[1]


def test_a_group_keeps_its_settings_to_itself(
    launched: Launch, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("GIVEN", "outside")
    words = ["printenv", "GIVEN"]
    show = LogInfo(msg=["a=", LaunchConfiguration("a"), " ", EnvironmentVariable("GIVEN")])
    inside = [
        SetLaunchConfiguration("a", "2"),
        SetEnvironmentVariable("GIVEN", "inside"),
        ExecuteProcess(cmd=words, output="screen"),
        TimerAction(period=0.01, actions=[LogInfo(msg=["later ", LaunchConfiguration("a")])]),
        show,
    ]
    first = SetLaunchConfiguration("a", "1")
    _, printed = launched(first, GroupAction(inside, launch_configurations={"b": "x"}), show)
    assert "a=2 inside" in printed
    assert "a=1 outside" in printed
    assert "later 2" in printed
    assert "] inside" in printed
    _, printed = launched(first, GroupAction(inside, scoped=False), show)
    assert printed.count("a=2 inside") == 2
    _, printed = launched(UnsetEnvironmentVariable("GIVEN"), show)
    assert "environment variable 'GIVEN' is not set" in printed or "'a' does not exist" in printed


def test_functions_and_coroutines_get_the_context(launched: Launch) -> None:
    async def later(context: LaunchContext) -> None:
        await asyncio.sleep(0.0)
        context.extend_locals({"seen": context.launch_configurations["n"]})

    def made(context: LaunchContext, prefix: str) -> list[Any]:
        return [LogInfo(msg=f"{prefix} {context.launch_configurations['n']}")]

    code, printed = launched(
        SetLaunchConfiguration("n", "5"),
        OpaqueCoroutine(coroutine=later),
        OpaqueFunction(function=made, args=["n is"]),
    )
    assert (code, "n is 5" in printed) == (0, True)


_FILES = {
    "a.launch.xml": """<launch>
  <push_env/><set_env name="OWN" value="set"/>
  <log message="[$(env OWN)]"/><pop_env/><log message="[$(env OWN none)]"/>
  <let name="a" value="1"/><unlet name="a"/><log message="a is $(var a gone)"/>
  <log message="$(dirname)"/><executable cmd="bash -c 'echo a/b'" output="screen"/>
</launch>""",
    "a.launch.yaml": """launch:
- push_env: {}
- set_env: {name: OWN, value: set}
- log: {message: "[$(env OWN)]"}
- pop_env: {}
- log: {message: "[$(env OWN none)]"}
- let: {name: a, value: 1}
- unlet: {name: a}
- log: {message: a is $(var a gone)}
- log: {message: $(dirname)}
- executable: {cmd: "bash -c 'echo a/b'", output: screen}
""",
}


@pytest.mark.parametrize("name", _FILES)
def test_files_of_xml_and_yaml_keep_and_drop_settings(
    name: str, tmp_path: Path, launched: Launch, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / name).write_text(_FILES[name])
    monkeypatch.chdir(tmp_path)
    code, printed = launched(IncludeLaunchDescription(name))
    said = [line.split("]: ", 1)[1] for line in printed.splitlines() if " [user]: " in line]
    assert said == ["[set]", "[none]", "a is gone", str(tmp_path)]
    assert (code, "[bash-" in printed) == (0, True)


@pytest.mark.parametrize(
    ("name", "text", "values"),
    [
        ("a.xml", "<param name='p' value='1; 2' value-sep='; '/>", "(1, 2)"),
        ("a.xml", "<param name='p' value=\"'1','b'\" value-sep=','/>", "('1', 'b')"),
        ("a.xml", "<param name='p' value='[$(var a), 2]'/>", "(1, 2)"),
        ("a.yaml", "{name: p, value: [1, 2.5]}", "(1.0, 2.5)"),
        ("a.yaml", "{name: p, value: ['1', b]}", "('1', 'b')"),
    ],
)
def test_parameters_of_xml_and_yaml_may_be_lists(
    name: str, text: str, values: str, tmp_path: Path
) -> None:
    context = LaunchContext()
    context.launch_configurations.update(CONTEXT)
    element = f"<launch><node pkg='p' exec='e'>{text}</node></launch>"
    document = f"launch: [{{node: {{pkg: p, exec: e, param: [{text}]}}}}]"
    (tmp_path / name).write_text(element if name == "a.xml" else document)
    node: Any = description_of(tmp_path / name).entities[0]
    (given,) = evaluate_parameters(context, node._Node__parameters)
    assert repr(given["p"]) == values


def test_a_node_starts_without_a_parameter_file_that_is_not_there(
    tmp_path: Path, launched: Launch
) -> None:
    given = [str(tmp_path / "a.yaml"), {"b": 1}]
    node = Node(executable="/bin/echo", parameters=given, output="screen")
    code, printed = launched(node)
    assert f"Parameter file path is not a file: {tmp_path}/a.yaml" in printed
    assert (code, printed.count("--params-file")) == (0, 1)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("$(arg map)", r"valid: \$\(var map\)"),
        ("$(find nav)/a.yaml", r"valid: \$\(find-pkg-share nav\)"),
        ("$(optenv HOME x)", r"valid: \$\(env HOME x\)"),
    ],
)
def test_ros_1_s_substitutions_are_told_with_those_of_ros_2(given: str, expected: str) -> None:
    with pytest.raises(InvalidLaunchFileError, match=expected):
        parse_substitution(given)


def test_a_launch_file_s_arguments_are_no_remappings(
    launched: Launch, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lifecycle, "_PATIENCE", 0.1)
    monkeypatch.setattr(sys, "argv", ["ros2", "launch", "a.launch.py", "label:=hello"])
    changes = LifecycleTransition(lifecycle_node_names=["nobody"], transition_ids=[1])
    _, printed = launched(changes)
    assert "Failed to make transition 1 of '/nobody'" in printed
    assert "deprecated" not in printed


def test_ctrl_c_ends_all_and_leaves_nothing(tmp_path: Path) -> None:
    text = (
        "from launch import *\nfrom launch.actions import *\ns = LaunchService()\n"
        "from nav2_common.launch import RewrittenYaml\n"
        "s.include_launch_description(LaunchDescription([ExecuteProcess(cmd=['bash', '-c',"
        f' \'trap "sleep 0.3; echo down; kill $!" INT; sleep 60 & echo $! > {tmp_path}/pid;'
        " cat $0; echo up; wait',"
        f" RewrittenYaml('{tmp_path}/a.yaml', {{'a': 'x'}})], output='screen')]))\n"
        "import os, sys\ncode = s.run()\nsys.stdout.flush()\nos._exit(code)"  # as `ros2` ends
    )
    (tmp_path / "a.yaml").write_text("a: b")
    (kept := tmp_path / "temporary").mkdir()
    environment = {**os.environ, "ROS_LOG_DIR": str(tmp_path), "TMPDIR": str(kept)}
    with subprocess.Popen(
        [sys.executable, "-c", text], stdout=subprocess.PIPE, text=True, env=environment
    ) as process:
        assert process.stdout is not None
        read = ""
        for awaited in ("] up", "user interrupted with ctrl-c (SIGINT)"):
            while awaited not in read:
                line = process.stdout.readline()
                assert line, read
                read += line
            process.send_signal(signal.SIGINT)  # twice, as `timeout` does: its group has it too
        read += process.communicate(timeout=30)[0]
    assert "] a: x" in read
    assert "] down" in read
    assert list(kept.iterdir()) == []
    assert process.returncode == 0
    status = Path(f"/proc/{(tmp_path / 'pid').read_text().strip()}/stat")
    assert not status.exists() or status.read_text().split()[2] == "Z"


_MODULES = ["launch.actions", "launch.event_handlers", "launch.conditions", "launch.substitutions"]
_ROS = ["launch_ros.actions", "launch_ros.descriptions", "launch_ros.substitutions"]


def test_a_file_may_import_all_names_of_all_modules() -> None:
    names: dict[str, Any] = {}
    for module in [*_MODULES, *_ROS, "nav2_common.launch"]:
        exec(f"from {module} import *", names)
    assert names["Shutdown"] is Shutdown  # the action: a handler's module knows the event too
    assert issubclass(names["PushLaunchConfigurations"], Action)
    assert {"ForEach", "AllSubstitution", "LifecycleTransition", "ParseMultiRobotPose"} <= set(
        names
    )


CONTEXT = {"a": "1", "path": "/x"}


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("plain", "plain"),
        ("$(var a)b$(var path)/c", "1b/x/c"),
        ("$(var nope other)", "other"),
        ("$(eval '$(var a) + 1')", "2"),
        ("$(eval $(var a) + 1)", "2"),
        ("$(command 'echo -n $(var a) two')", "1 two"),
        ("$(not $(equals $(var a) 2))", "true"),
        ("$(and true $(or false 1))", "true"),
        ("$(if $(equals $(var a) 1.0) yes 'n o')", "yes"),
        ("$(not-equals a b)", "true"),
        ("$(env NO_SUCH_VARIABLE 'de fault')", "de fault"),
        ("cost (of $(var a))", "cost (of 1)"),
    ],
)
def test_a_text_with_substitutions(text: str, value: str) -> None:
    context = LaunchContext()
    context.launch_configurations.update(CONTEXT)
    assert perform_substitutions(context, parse_substitution(text)) == value


@pytest.mark.parametrize(
    ("substitution", "value"),
    [
        (PathJoinSubstitution(["/a", ["b", "c"]]) / "d", "/a/bc/d"),
        (PythonExpression(["'", LaunchConfiguration("a"), "' == '1' and pi > 3"]), "True"),
        (Command(["echo ", "-n ", LaunchConfiguration("a")]), "1"),
        (LaunchConfiguration("a") == "1", "true"),
        (LaunchConfiguration("b", default=False), "False"),
        (LaunchConfiguration("b", default=["x", 5]), "x5"),
        (LaunchConfiguration("b", default=LaunchConfiguration("path")), "/x"),
        (LaunchConfiguration("a") != "2", "true"),
    ],
)
def test_a_substitution_has_its_value(substitution: Any, value: str) -> None:
    context = LaunchContext()
    context.launch_configurations.update(CONTEXT)
    assert perform_substitutions(context, substitution) == value


@pytest.mark.parametrize(
    ("substitution", "problem"),
    [
        (PythonExpression(["1 /"]), "failed to evaluate '1 /'"),
        (Command("false"), "'false' failed"),
        (Command("sh -c 'echo no >&2'"), "wrote to standard error: no; on_stderr='ignore'"),
        (Command("no_such_program"), "'no_such_program' failed"),
    ],
)
def test_a_substitution_without_a_value_says_why(substitution: Substitution, problem: str) -> None:
    with pytest.raises(SubstitutionFailure, match=problem.replace("(", "\\(")):
        substitution.perform(LaunchContext())


@pytest.mark.parametrize(
    ("given", "value"),
    [
        ([1, 2.5], "[1.0, 2.5]"),
        ([0, 1], "[0, 1]"),
        ([True, False], "[True, False]"),
        (["a", "5"], "['a', '5']"),
        (["[0, ", LaunchConfiguration("a"), ".5]"], "[0.0, 1.5]"),
        ([["x", LaunchConfiguration("a")], "y"], "['x1', 'y']"),
        (LaunchConfiguration("a"), "1"),
        (ParameterValue(LaunchConfiguration("a"), value_type=str), "'1'"),
        (ParameterValue(LaunchConfiguration("a"), value_type=float), "1.0"),
        (ParameterValue("!!int x"), "'!!int x'"),
        (ParameterValue("[" * 5000, value_type=str), repr("[" * 5000)),
        (ParameterValue(["[" * 5000]), repr(["[" * 5000])),
    ],
)
def test_a_parameter_has_one_type(given: Any, value: str) -> None:
    context = LaunchContext()
    context.launch_configurations.update(CONTEXT)
    assert repr(value_of(context, given)) == value


def test_a_substitution_of_one_s_own_is_known_in_texts() -> None:
    @expose_substitution("upper")
    class Upper(Substitution):
        def __init__(self, word: Any) -> None:
            self.word = word

        @classmethod
        def parse(cls, words: Any) -> Any:
            return cls, {"word": words[0]}

        def perform(self, context: LaunchContext) -> str:
            return perform_substitutions(context, self.word).upper()

    assert perform_substitutions(LaunchContext(), parse_substitution("$(upper a)b")) == "Ab"


def test_a_file_that_is_rewritten_in_a_context_of_its_own_is_there_when_it_is_read(
    tmp_path: Path, launched: Launch
) -> None:
    (tmp_path / "nav2.yaml").write_text("amcl: {ros__parameters: {alpha1: 0.2}}")
    rewritten = RewrittenYaml(
        source_file=str(tmp_path / "nav2.yaml"),
        param_rewrites={"alpha1": "0.7"},
        convert_types=True,
    )
    path = rewritten.perform(LaunchContext())
    gc.collect()
    reader = ExecuteProcess(cmd=["cat", path], output="screen")
    code, said = launched(reader)
    assert (code, "alpha1: 0.7" in said) == (0, True)


def test_rewritten_parameters_are_there_by_their_whole_path(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("a: {ros__parameters: {b: 1, c: 2}}\ne:")
    rewrites = {"a.ros__parameters.d": "0.5", "c": "3", "e.ros__parameters.f": "g"}
    made = RewrittenYaml([str(tmp_path), "/a.yaml"], rewrites, root_key="/r", convert_types=True)
    context = LaunchContext()
    written = yaml.safe_load(Path(made.perform(context)).read_text())
    rest = {"e": {"ros__parameters": {"f": "g"}}}
    assert written == {"r": {"a": {"ros__parameters": {"b": 1, "c": 3, "d": 0.5}}, **rest}}


def test_a_launch_file_that_includes_itself_ends(tmp_path: Path, launched: Launch) -> None:
    path = tmp_path / "a.launch.xml"
    path.write_text('<launch><include file="$(dirname)/a.launch.xml"/></launch>')
    code, printed = launched(IncludeLaunchDescription(str(path)))
    assert (code, f"launch file {path} is included 30 deep" in printed) == (1, True)


@pytest.mark.parametrize(
    ("rewrites", "expected"),
    [
        ({"b": "true", "c": "2.50", "f": "12"}, {"b": True, "c": 2.5, "f": 12}),
        ({"b": "", "c": "off", "f": "[[0.1, 0.2]]"}, {"b": "", "c": "off", "f": "[[0.1, 0.2]]"}),
        ({"b": "1", "n.ros__parameters.b": "2"}, {"b": 2}),
        (
            {"n.ros__parameters.f.1": "9", "n.ros__parameters.g.h": "x"},
            {"f": [1, 9], "g": {"h": "x"}},
        ),
    ],
)
def test_rewritten_values_are_of_nav2_s_types(
    rewrites: dict[str, str], expected: dict[str, Any], tmp_path: Path
) -> None:
    (tmp_path / "a.yaml").write_text("n: {ros__parameters: {b: 0, c: 0, f: [1, 2]}}")
    made = RewrittenYaml(str(tmp_path / "a.yaml"), rewrites, convert_types=True)
    context = LaunchContext()  # its files are there as long as it is
    written = yaml.safe_load(Path(made.perform(context)).read_text())
    given = written["n"]["ros__parameters"]
    assert given == {"b": 0, "c": 0, "f": [1, 2], **expected}
    assert {key: type(given[key]) for key in expected} == {k: type(v) for k, v in expected.items()}


def test_a_file_s_content(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("text")
    assert FileContent([str(tmp_path), "/a.txt"]).perform(LaunchContext()) == "text"
