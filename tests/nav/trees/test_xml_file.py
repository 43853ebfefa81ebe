"""Trees from XML: Nav2's own, hostile ones, and what is said of a mistake."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.files.shipped import shipped_file
from arjuna_nav.trees.ports import TreeError
from arjuna_nav.trees.xml_file import build_tree, read_tree

SHIPPED = sorted(shipped_file("behavior_trees").glob("*.xml"))


def root(inside: str, attributes: str = "") -> str:
    tree = f'<BehaviorTree ID="T">{inside}</BehaviorTree>'
    return f'<root BTCPP_format="4" {attributes}>{tree}</root>'


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_the_shipped_trees_are_built(path: Path) -> None:
    choices = {"controller_selector", "planner_selector"}
    assert {topic.name for topic in read_tree(path).topics} == choices


def test_there_are_shipped_trees() -> None:
    assert len(SHIPPED) == 9


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "no XML"),
        ("<root>", "no XML"),
        ("<tree/>", "outermost element is <tree>; valid: <root>"),
        ("<root/>", "main_tree_to_execute is 'None'"),
        (root("<AlwaysSuccess/>", 'main_tree_to_execute="M"'), "is 'M', no tree of the file"),
        (root(""), "has 0 children; valid: 1"),
        (root("<AlwaysSuccess/><AlwaysSuccess/>"), "has 2 children; valid: 1"),
        (root("<ComputePathToPos goal='{g}'/>"), "did you mean 'ComputePathToPose'?"),
        (root("<Action ID='Spinn'/>"), "no node 'Spinn'; did you mean 'Spin'?"),
        (root("<Spin spin_distance='1'/>"), "no port 'spin_distance'; did you mean 'spin_dist'?"),
        (root("<Spin spin_dist='far'/>"), "port 'spin_dist' is 'far'; valid: a number"),
        (root("<Spin spin_dist='nan'/>"), "valid: a number"),
        (root("<FollowPath path='here'/>"), "port 'path' is 'here'; valid: a path on"),
        (root("<FollowPath path='{p}' error_code_id='code'/>"), "in braces"),
        (root("<Parallel success_count='1.5'><Wait/></Parallel>"), "a whole number"),
        (root("<RecoveryNode><Wait/></RecoveryNode>"), "has 1 children; valid: 2"),
        (root("<Sequence/>"), "has 0 children; valid: 1 or more"),
        (root("<Spin><Wait/></Spin>"), "has 1 children; valid: 0"),
        (root("<Spin _skipIf='a &gt; 1'/>"), "'_skipIf' (scripts and conditions) is not offered"),
        (root("<SubTree ID='Other'/>"), "there is no tree 'Other'"),
        (root("<SubTree ID='T'/>"), "tree 'T' holds itself: T > T"),
        ("<root><include path='/etc/passwd'/></root>", "<include> is not offered"),
        ("<!DOCTYPE a [<!ENTITY b 'c'>]><root>&b;</root>", "no XML, or one with a DTD"),
        (root("<Inverter>" * 200 + "<Wait/>" + "</Inverter>" * 200), "deeper than 100"),
        (root("<Sequence>" + "<Wait/>" * 2001 + "</Sequence>"), "over 2000 nodes"),
    ],
)
def test_a_mistake_is_named(text: str, says: str) -> None:
    with pytest.raises(TreeError, match=r"^mine\.xml: ") as error:
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
