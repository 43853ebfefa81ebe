"""Trees from XML: Nav2's own, hostile ones, and what is said of a mistake."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.files.shipped import shipped_file
from arjuna_core.se2 import SE2
from arjuna_nav.trees.blackboard import TreeError
from arjuna_nav.trees.exchange import Ask, TreeState
from arjuna_nav.trees.node import Status
from arjuna_nav.trees.xml_file import build_tree, read_tree

SHIPPED = sorted(shipped_file("behavior_trees").glob("*.xml"))


def root(inside: str, attributes: str = "") -> str:
    tree = f'<BehaviorTree ID="T">{inside}</BehaviorTree>'
    return f'<root BTCPP_format="4" {attributes}>{tree}</root>'


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_the_shipped_trees_are_built(path: Path) -> None:
    choices = {"controller_selector", "planner_selector"}
    if "_w_" not in path.stem:  # Arjuna's own
        choices |= {"goal_checker_selector", "progress_checker_selector"}
    assert {topic.name for topic in read_tree(path).topics} == choices


def test_there_are_shipped_trees() -> None:
    assert len(SHIPPED) == 11


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "is empty; valid: XML"),
        ("<root>", "line 1: is broken XML"),
        ("<tree/>", "outermost element is <tree>; valid: <root>"),
        ("<root/>", "main_tree_to_execute is 'None'"),
        (root("<AlwaysSuccess/>", 'main_tree_to_execute="M"'), "is 'M', no tree of the file"),
        (root(""), "has 0 children; valid: 1"),
        (root("<AlwaysSuccess/><AlwaysSuccess/>"), "has 2 children; valid: 1"),
        (root("<ComputePathToPos goal='{g}'/>"), "did you mean 'ComputePathToPose'?"),
        (root("<Action ID='Spinn'/>"), "no node 'Spinn'; did you mean 'Spin'?"),
        (root("<Action action_name='Wait'/>"), "<Action> has no ID; valid: <Action ID='...'>"),
        (root("<Spin spin_distance='1'/>"), "no port 'spin_distance'; did you mean 'spin_dist'?"),
        (root("<Spin spin_dist='far'/>"), "port 'spin_dist' is 'far'; valid: a number"),
        (root("<Spin spin_dist='nan'/>"), "valid: a number"),
        (root("<FollowPath path='here'/>"), "port 'path' is 'here'; valid: a path on"),
        (root("<FollowPath path='{p}' error_code_id='code'/>"), "in braces"),
        (root("<Parallel success_count='1.5'><Wait/></Parallel>"), "a whole number"),
        (root("<RecoveryNode><Wait/></RecoveryNode>"), "has 1 children; valid: 2"),
        (root("<Sequence/>"), "has 0 children; valid: 1 or more"),
        (root("<Spin><Wait/></Spin>"), "has 1 children; valid: 0"),
        (root("<Spin _skipIf='a &gt; '/>"), "'_skipIf': script 'a > ': it ends too early"),
        (root("<Spin _skipif='a'/>"), "no port '_skipif'; did you mean '_skipIf'?"),
        (root("<Script code='1 +* 2'/>"), "port 'code': script '1 +* 2': unexpected '*'"),
        (root("<Switch2 case_1='a'><Wait/><Wait/></Switch2>"), "has 2 children; valid: 3"),
        (root("<SubTree ID='Other'/>"), "there is no tree 'Other'"),
        (root("<SubTree ID='T'/>"), "tree 'T' holds itself: T > T"),
        ("<root><include path='/etc/passwd'/></root>", "lies outside"),
        ("<root><include path='../x.xml'/></root>", "lies outside"),
        ("<root><include path='none.xml'/></root>", "none.xml"),
        ("<!DOCTYPE a [<!ENTITY b 'c'>]><root>&b;</root>", "declares a DTD or entities"),
        (root("<Inverter>" * 200 + "<Wait/>" + "</Inverter>" * 200), "more than 100 nested"),
        (root("<Sequence>" + "<Wait/>" * 2001 + "</Sequence>"), "over 2000 nodes"),
    ],
)
def test_a_mistake_is_named(text: str, says: str) -> None:
    with pytest.raises(TreeError, match=r"^(mine\.xml|.*none\.xml)") as error:
        build_tree(text, "mine.xml")
    assert says in str(error.value)


def test_subtrees_that_hold_each_other_many_times_are_bounded() -> None:
    trees = []
    for k in range(10):
        calls = f"<SubTree ID='T{k + 1}'/>" * 10
        trees.append(f"<BehaviorTree ID='T{k}'><Sequence>{calls}</Sequence></BehaviorTree>")
    last = "<BehaviorTree ID='T10'><Wait/></BehaviorTree>"
    text = f"<root main_tree_to_execute='T0'>{''.join(trees)}{last}</root>"
    with pytest.raises(TreeError, match="over 2000 nodes"):
        build_tree(text, "mine.xml")


def test_files_that_cannot_be_read_or_are_too_large(tmp_path: Path) -> None:
    with pytest.raises(TreeError, match="cannot be read"):
        read_tree(tmp_path / "none.xml")
    large = tmp_path / "large.xml"
    large.write_text("<!-- -->" * 200_000, encoding="utf-8")
    with pytest.raises(TreeError, match="at most 1000000"):
        read_tree(large)


def _tree(name: str, inside: str) -> str:
    return f"<BehaviorTree ID='{name}'>{inside}</BehaviorTree>"


def test_trees_of_included_files_are_subtrees(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    main = "<include path='parts/a.xml'/><include path='main.xml'/>" + _tree(
        "Main", "<SubTree ID='A'/>"
    )
    (tmp_path / "main.xml").write_text(
        f"<root main_tree_to_execute='Main'>{main}</root>", encoding="utf-8"
    )
    a = "<root><include path='b.xml'/>" + _tree("A", "<SubTree ID='B'/>") + "</root>"
    (tmp_path / "parts" / "a.xml").write_text(a, encoding="utf-8")
    circle = "<root><include path='a.xml'/>" + _tree("B", "<AlwaysSuccess/>") + "</root>"
    (tmp_path / "parts" / "b.xml").write_text(circle, encoding="utf-8")
    assert read_tree(tmp_path / "main.xml").tick(TreeState(0.0))[0] is Status.SUCCESS


def test_a_file_of_another_package_is_the_shipped_one(tmp_path: Path) -> None:
    (tmp_path / "main.xml").write_text(
        "<root main_tree_to_execute='NavigateToPose'>"
        "<include ros_pkg='nav2_bt_navigator' path='trees/navigate_to_pose.xml'/></root>",
        encoding="utf-8",
    )
    assert len(read_tree(tmp_path / "main.xml").topics) == 4


def test_a_file_of_ones_own_package_is_that_of_its_share(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    share = tmp_path / "install" / "share" / "my_robot" / "trees"
    share.mkdir(parents=True)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "install"))
    name = "navigate_to_pose.xml"  # as one of the shipped ones
    text = "<root>" + _tree("NavigateToPose", "<AlwaysFailure/>") + "</root>"
    (tmp_path / name).write_text(text, encoding="utf-8")
    (share / name).symlink_to(tmp_path / name)  # as colcon's --symlink-install does
    (tmp_path / "main.xml").write_text(
        "<root main_tree_to_execute='NavigateToPose'>"
        f"<include ros_pkg='my_robot' path='trees/{name}'/></root>",
        encoding="utf-8",
    )
    assert read_tree(tmp_path / "main.xml").tick(TreeState(0.0))[0] is Status.FAILURE


def test_included_files_are_bounded(tmp_path: Path) -> None:
    for k in range(30):
        text = f"<root><include path='{k + 1}.xml'/>" + _tree(f"T{k}", "<Wait/>") + "</root>"
        (tmp_path / f"{k}.xml").write_text(text, encoding="utf-8")
    with pytest.raises(TreeError, match="over 20 files are included"):
        read_tree(tmp_path / "0.xml")


@pytest.mark.parametrize("code", ["c := 1 < 2 && true", "c := 1 &lt; 2 &amp;&amp; true"])
def test_scripts_hold_their_operators_as_they_are(code: str) -> None:
    tree = build_tree(root(f"<Script code='{code}'/>"), "test.xml")
    assert tree.tick(TreeState(0.0))[0] is Status.SUCCESS
    assert tree.blackboard.get("c") is True


@pytest.mark.parametrize("sharing", ["_autoremap", "__autoremap", "__shared_blackboard"])
def test_a_subtree_has_entries_of_its_own(sharing: str) -> None:
    text = (
        '<root BTCPP_format="4" main_tree_to_execute="Main">'
        '<BehaviorTree ID="Main"><Sequence><SubTree ID="Sub" goal="{aim}" speed="0.2"/>'
        f'<SubTree ID="Share" {sharing}="true"/></Sequence></BehaviorTree>'
        '<BehaviorTree ID="Sub"><Sequence><GoalReached goal="{goal}"/>'
        '<SetBlackboard value="{speed}" output_key="hidden"/>'
        '<SetBlackboard value="{speed}" output_key="@seen"/></Sequence></BehaviorTree>'
        '<BehaviorTree ID="Share"><SetBlackboard value="1" output_key="shared"/></BehaviorTree>'
        "</root>"
    )
    tree = build_tree(text, "test.xml")
    tree.blackboard.set("aim", SE2())
    assert tree.tick(TreeState(0.0, SE2()))[0] is Status.SUCCESS
    board = tree.blackboard
    assert [board.get(name) for name in ("hidden", "seen", "shared")] == [None, "0.2", "1"]


@pytest.mark.parametrize("text", ["{on}", " {on} ", "${on}"])
def test_an_entry_stands_in_braces_and_after_a_dollar_sign_too(text: str) -> None:
    code = f"<ToggleCollisionMonitor enable='{text}'/>"
    tree = build_tree(root(f"<Sequence><Script code='on := false'/>{code}</Sequence>"), "t.xml")
    _, (asked,) = tree.tick(TreeState(0.0))
    assert isinstance(asked, Ask)
    assert asked.fields == {"enable": False}


def test_a_port_may_say_that_its_entry_has_its_own_name() -> None:
    copy = '<SetBlackboard value="{=}" output_key="seen"/>'
    subtree = '<SubTree ID="Sub" value="{=}" seen="{=}"/>'
    text = f'<root main_tree_to_execute="Main">{_tree("Main", subtree)}{_tree("Sub", copy)}</root>'
    tree = build_tree(text, "test.xml")
    tree.blackboard.set("value", 3)
    tree.tick(TreeState(0.0))
    assert tree.blackboard.get("seen") == 3


def test_a_subtree_takes_the_defaults_of_its_model() -> None:
    model = '<input_port name="speed" default="{fast}"/><output_port name="seen"/>'
    copy = _tree("Sub", '<SetBlackboard value="{speed}" output_key="seen"/>')
    models = f'<TreeNodesModel><SubTree ID="Sub">{model}</SubTree></TreeNodesModel>'
    for passed, seen in (('seen="{=}"', 3), ('seen="{=}" speed="1"', "1"), ("", None)):
        main = _tree("Main", f'<SubTree ID="Sub" {passed}/>')
        text = f'<root main_tree_to_execute="Main">{main}{copy}{models}</root>'
        if not passed:
            with pytest.raises(TreeError, match=r"<SubTree ID='Sub'> lacks \['seen'\]"):
                build_tree(text, "test.xml")
            continue
        tree = build_tree(text, "test.xml")
        tree.blackboard.set("fast", 3)
        tree.tick(TreeState(0.0))
        assert tree.blackboard.get("seen") == seen


def test_a_subtree_s_conditions_are_of_the_tree_that_it_stands_in() -> None:
    subtree = '<SubTree ID="Sub" _skipIf="tired" _onSuccess="done := true"/>'
    trees = _tree("Main", subtree) + _tree("Sub", '<Script code="tired := true"/>')
    tree = build_tree(f'<root main_tree_to_execute="Main">{trees}</root>', "test.xml")
    tree.blackboard.set("tired", False)
    assert [tree.tick(TreeState(0.0))[0] for _ in range(2)] == [Status.SUCCESS] * 2
    assert tree.blackboard.get("done") is True
    tree.blackboard.set("tired", True)
    assert tree.tick(TreeState(0.0))[0] is Status.SKIPPED


def test_two_trees_of_one_name_are_refused_with_both_files(tmp_path: Path) -> None:
    text = "<root>" + _tree("A", "<AlwaysSuccess/>") + "</root>"
    (tmp_path / "part.xml").write_text(text, encoding="utf-8")
    main = "<include path='part.xml'/>" + _tree("A", "<AlwaysFailure/>")
    with pytest.raises(TreeError, match=r"main: .*ID='A'> stands in .*part.xml, too"):
        build_tree(f"<root>{main}</root>", "main", tmp_path)
