"""Launch tests as users write them: files of launch_testing, functions of launch_pytest, docs."""

from __future__ import annotations

import re
import subprocess
import sys
import threading
from contextlib import closing
from pathlib import Path
from xml.etree import ElementTree

import pytest
import rclpy
from launch_testing.tools import basic_output_filter, expect_output, output
from launch_testing.tools.text import normalize_lineseps
from launch_testing_ros import DataRepublisher, MessagePump
from rclpy.context import Context
from std_msgs.msg import String

from arjuna_core.files.shipped import shipped_file
from tests.helpers.ros import RosBench

PAGE = shipped_file("docs/ci.md").read_text(encoding="utf-8")
HEAD = """
import sys, unittest
import launch, launch_pytest, launch_testing, pytest
import launch_testing.actions, launch_testing.asserts, launch_testing.markers
from launch.actions import ExecuteProcess, TimerAction
from launch_pytest.tools import process as process_tools

def python(code, **more):
    return ExecuteProcess(cmd=[sys.executable, "-c", code], **more)

READY = launch_testing.actions.ReadyToTest
"""
SPEAKER = """
@pytest.mark.launch_test
@launch_testing.parametrize("word", ["one", "two"])
def generate_test_description(word):
    say = f"import sys, time; print('out {word}'); print('err {word}', file=sys.stderr)"
    speaker = python(say + "; time.sleep(0.3); print('done'); time.sleep(60)", name="speaker")
    short = ExecuteProcess(cmd=["true"], name="short")
    ready = launch_testing.event_handlers.StdoutReadyListener(
        target_action=speaker, ready_txt="out", actions=[READY()])
    later = launch.actions.RegisterEventHandler(ready)
    return launch.LaunchDescription([speaker, short, later]), {"speaker": speaker, "short": short}

class TestBeside(unittest.TestCase):
    @classmethod
    def setUpClass(cls, word):
        cls.given = word

    def setUp(self, proc_info):
        self.info = proc_info

    def test_output(self, proc_output, speaker, word):
        proc_output.assertWaitFor(f"out {word}", process=speaker, stream="stdout", timeout=9)
        proc_output.assertWaitFor(["err", word], process="speak")
        self.proc_output.assertWaitFor("done", stream="stdout", timeout=9)
        assert self.given == word
        with self.assertRaisesRegex(AssertionError, "'no' did not come from any process on stderr"):
            proc_output.assertWaitFor("no", timeout=0.1)

    def test_ends(self, proc_info, short):
        self.info.assertWaitForShutdown(process=short, timeout=9)
        with self.assertRaisesRegex(AssertionError, "did not start within 0.1 s"):
            proc_info.assertWaitForStartup(process="nobody", timeout=0.1)

    def test_another(self, launch_service, proc_info, proc_output):
        tools, more = launch_testing.tools, python("print(input)", name="more")
        with tools.launch_process(launch_service, more, proc_info, proc_output) as process:
            assert process.wait_for_output("function input", timeout=9)
            assert process.wait_for_shutdown(timeout=9)
        assert process.exit_code == 0

@launch_testing.post_shutdown_test()
class TestBehind(unittest.TestCase):
    def test_codes(self, proc_info, speaker):
        launch_testing.asserts.assertExitCodes(proc_info, process="short")
        launch_testing.asserts.assertExitCodes(proc_info, [-2, 1, 130], process=speaker)
        with self.assertRaisesRegex(AssertionError, "speaker-.* ended with exit code"):
            launch_testing.asserts.assertExitCodes(proc_info, [7])

    def test_order(self, proc_output, speaker):
        launch_testing.asserts.assertInStdout(proc_output, "done", speaker)
        with launch_testing.asserts.assertSequentialStdout(proc_output, speaker) as lines:
            lines.assertInStdout("out")
            lines.assertInStdout("done")
"""
FUNCTIONS = """
@pytest.fixture
def speaker():
    return python("print('hello'); import time; time.sleep(60)", cached_output=True)

@launch_pytest.fixture
def description(speaker):
    return launch.LaunchDescription([speaker, launch_pytest.actions.ReadyToTest()])

MARK = pytest.mark.launch(fixture=description)

@MARK
def test_a_function(speaker, launch_context):
    process_tools.assert_output_sync(launch_context, speaker, lambda out: "hello" in out, 9)

@MARK
async def test_a_coroutine(speaker, launch_context):
    def says_hello(out):
        assert "hello" in out
    await process_tools.assert_output(launch_context, speaker, says_hello, timeout=9)

@MARK
def test_both_sides(speaker, launch_context):
    assert process_tools.wait_for_start_sync(launch_context, speaker, timeout=9)
    yield
    assert speaker.return_code is not None

@MARK
async def test_both_sides_of_a_coroutine(speaker, launch_context):
    assert await process_tools.wait_for_start(launch_context, speaker, timeout=9)
    yield
    assert speaker.return_code is not None

@pytest.mark.launch(fixture=description, shutdown=True)
def test_behind(speaker):
    assert speaker.return_code is not None

@MARK
class TestClass:
    @pytest.mark.parametrize("number", [1, 2])
    def test_in_a_class(self, number, launch_service):
        assert not launch_service.context.is_shutdown

@MARK
@pytest.mark.xfail(strict=True, raises=AssertionError)
def test_wrong(speaker, launch_context):
    process_tools.assert_output_sync(launch_context, speaker, lambda out: out == "bye", timeout=0.5)

@MARK
@pytest.mark.xfail(strict=True, raises=AssertionError)
def test_wrong_behind(speaker):
    yield
    assert speaker.return_code == 77
"""
ENDED = """
@pytest.mark.launch_test
def generate_test_description():
    return launch.LaunchDescription([ExecuteProcess(cmd=["true"]), READY()])

class TestBeside(unittest.TestCase):
    def test_a_wrong_one(self):
        self.assertEqual(1, 2)

    def test_too_long(self, proc_output):
        proc_output.assertWaitFor("never", timeout=60)
"""
KEPT = """
@pytest.mark.launch_test
@launch_testing.markers.keep_alive
def generate_test_description():
    return launch.LaunchDescription([READY()])

class TestBeside(unittest.TestCase):
    tries = 0

    @launch_testing.markers.retry_on_failure(times=2)
    def test_again(self):
        type(self).tries += 1
        assert self.tries == 2

    def test_left_out(self):
        self.skipTest("not here")
"""
PROGRAM = """
from launch_testing.legacy import LaunchTestService

description = launch.LaunchDescription([python("import time; time.sleep(60)")])
test = python(f"raise SystemExit({sys.argv[1]})", name="tester")
tests = LaunchTestService()
tests.add_test_action(description, test)
service = launch.LaunchService()
service.include_launch_description(description)
sys.exit(tests.run(service))
"""


def run(folder: Path, text: str, *words: str) -> subprocess.CompletedProcess[str]:
    """Write a file of tests, and run it by a program's words."""
    (folder / "test_it.py").write_text(HEAD + text, encoding="utf-8")
    command = [sys.executable, *words]
    return subprocess.run(
        command, cwd=folder, capture_output=True, text=True, timeout=100, check=False
    )


@pytest.mark.parametrize("words", [("launch_testing.launch_test",), ("pytest", "-q")])
def test_a_file_s_tests_run_beside_its_launch_and_behind_its_end(
    tmp_path: Path, words: tuple[str, ...]
) -> None:
    more = () if "pytest" in words else ("--junit-xml", "out/results.xml")
    ended = run(tmp_path, SPEAKER, "-m", *words, "test_it.py", *more)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    if more:
        suites = ElementTree.parse(tmp_path / "out" / "results.xml").getroot()
        assert [(suite.get("tests"), suite.get("failures")) for suite in suites] == [("5", "0")] * 2
    else:
        assert "2 passed" in ended.stdout


def test_functions_run_beside_a_fixture_s_launch(tmp_path: Path) -> None:
    ended = run(tmp_path, FUNCTIONS, "-m", "pytest", "-q", "test_it.py")
    assert "7 passed, 2 xfailed" in ended.stdout, ended.stdout + ended.stderr


def test_a_failure_says_what_was_wrong(tmp_path: Path) -> None:
    ended = run(tmp_path, ENDED, "-m", "launch_testing.launch_test", "test_it.py")
    assert ended.returncode == 1
    assert "AssertionError: 1 != 2" in ended.stdout
    assert "all processes ended before the tests did" in ended.stdout
    by_pytest = run(tmp_path, ENDED, "-m", "pytest", "-q", "test_it.py")
    assert by_pytest.returncode == 1
    assert "all processes ended before the tests did" in by_pytest.stdout


def test_a_launch_is_kept_alive_and_a_test_tried_again(tmp_path: Path) -> None:
    ended = run(tmp_path, KEPT, "-m", "launch_testing.launch_test", "test_it.py")
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert "[skipped] TestBeside.test_left_out" in ended.stdout


@pytest.mark.parametrize("code", [0, 3])
def test_a_program_s_exit_code_is_that_of_its_test(tmp_path: Path, code: int) -> None:
    assert run(tmp_path, PROGRAM, "test_it.py", str(code)).returncode == code


def test_a_test_that_is_no_process_ends_when_it_is_done(tmp_path: Path) -> None:
    timer = "launch.actions.TimerAction(period=0.5, actions=[python('print(1 + 1)')])"
    text = PROGRAM.replace('python(f"raise SystemExit({sys.argv[1]})", name="tester")', timer)
    ended = run(tmp_path, text, "test_it.py")
    assert ended.returncode == 0, ended.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nowhere.py"], "there is no file nowhere.py"),
        (["test_it.py"], "has no function generate_test_description"),
        (["test_it.py", "x"], "'x' is no launch argument; valid: NAME:=VALUE"),
    ],
)
def test_what_is_no_launch_test_is_said(tmp_path: Path, words: list[str], said: str) -> None:
    ended = run(tmp_path, "", "-m", "launch_testing.launch_test", *words)
    assert (ended.returncode, said in ended.stderr) == (2, True), ended.stderr


def test_what_the_page_shows_runs(tmp_path: Path) -> None:
    (in_steps,) = re.findall(r"^```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    (launched,) = re.findall(r"^```py\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    (tmp_path / "test_steps.py").write_text(in_steps, encoding="utf-8")
    steps = ["test_steps.py", "--deselect", "test_steps.py::test_it_drives_round_the_box[1]"]
    ended = run(tmp_path, launched, "-m", "pytest", "-q", *steps, "test_it.py")
    assert "3 passed, 1 deselected" in ended.stdout, ended.stdout + ended.stderr


def test_tools_have_the_modules_of_the_original(tmp_path: Path) -> None:
    assert normalize_lineseps("a\r\nb\r\n") == "a\nb\n"
    assert normalize_lineseps("a\nb") == "a\nb"
    (tmp_path / "said.txt").write_text("one\ntwo\n")
    (tmp_path / "seen.regex").write_text("[0-9]+\n")
    assert expect_output(
        expected_text=output.expected_output_from_file(str(tmp_path / "said")), text="one\ntwo"
    )
    (pattern,) = output.expected_output_from_file(str(tmp_path / "seen"))
    assert pattern.match("17")
    with pytest.raises(FileNotFoundError, match="is there"):
        output.expected_output_from_file(str(tmp_path / "nothing"))
    drop = basic_output_filter(filtered_prefixes=output.get_default_filtered_prefixes())
    assert drop("pid 1\nkept\n") == "kept\n"


def test_a_node_is_pumped_beside_a_test() -> None:
    context = Context()
    rclpy.init(context=context)
    node = rclpy.create_node("pumped", context=context)
    done = threading.Event()
    node.create_timer(0.01, done.set)
    pump = MessagePump(node, context=context)
    pump.start()
    assert done.wait(10.0)
    pump.stop()
    rclpy.shutdown(context=context)


def test_messages_are_changed_or_dropped_between_two_topics() -> None:
    with closing(RosBench()) as ros:
        changes = {"drop": None, "take": String(data="taken")}
        between = DataRepublisher(ros.node, "/in", "/out", String, lambda m: changes[m.data])
        heard = ros.collect(String, "/out")
        for word in changes:
            ros.publish(String, "/in", String(data=word))
        assert [each.data for each in heard] == ["taken"]
        assert (between.get_num_received(), between.get_num_republished()) == (2, 1)
        assert [each.data for each in between.get_republished()] == ["take"]
        between.shutdown()
        ros.publish(String, "/in", String(data="take"))
        assert between.get_num_received() == 2
