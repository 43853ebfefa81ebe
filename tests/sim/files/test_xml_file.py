"""Reading XML that nobody vouches for, and the errors of values in it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from arjuna_core.errors import InputFileError, WorldError
from arjuna_core.files.xml_text import DEPTH_MAX, parse_xml
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.notes import Note, NoteKind


def file(inside: str = "", tag: str = "sdf") -> XmlFile:
    return XmlFile(Path("w.sdf"), tag, WorldError, f"<sdf>{inside}</sdf>".encode())


XML = file("<a n=' 7 ' blank=' ' long='{}'><b>2.9</b><c>x</c></a>".format("y" * 1001))
ROOT = XML.root[0]


def refused(problem: str) -> pytest.RaisesExc[WorldError]:
    return pytest.raises(WorldError, match=f"w.sdf.*{re.escape(problem)}")


def test_numbers_are_as_many_as_asked_for_and_finite() -> None:
    assert XML.numbers(" 1  -2e3 ", 2, "here") == (1.0, -2000.0)
    for text, problem in (
        ("1 2 3", "has 3 numbers ('1 2 3'); valid: 2"),
        ("1 two", "'1 two' is not 2 numbers"),
        ("1 inf", "'1 inf' must be finite"),
        ("nan 1", "'nan 1' must be finite"),
    ):
        with refused(problem):
            XML.numbers(text, 2, "here")
    with pytest.raises(WorldError, match="here"):
        XML.numbers("", 1, "here")


def test_lengths_are_above_zero_and_no_larger_than_a_landscape() -> None:
    assert XML.sizes("1e5 1e-9", 2, "here") == (1e5, 1e-9)
    with refused("'1 0' must be above zero"):
        XML.sizes("1 0", 2, "here")
    with refused("'1 100001' is too large; valid: up to 100000"):
        XML.sizes("1 100001", 2, "here")
    with refused("must be above zero"):
        XML.sizes("-1", 1, "here")
    assert XML.position("1e6 -1e6 0", "here") == (1e6, -1e6, 0.0)
    for far in ("0 1000001 0", "0 0 -1000001"):
        with refused(f"'{far}' is too far; valid: up to 1e+06"):
            XML.position(far, "here")


def test_children_and_attributes_have_defaults_or_must_be_there() -> None:
    assert XML.number(ROOT, "b", 5.0, "here") == 2.9
    assert XML.number(ROOT, "none", 5.0, "here") == 5.0
    assert XML.number(None, "b", 5.0, "here") == 5.0
    assert XML.count(ROOT, "b", 5, "here") == 2  # cut to a whole one
    assert XML.count(None, "b", 1_000_000, "here") == 1_000_000
    with refused("is too large"):
        XML.count(None, "b", -1_000_001, "here")
    with pytest.raises(WorldError, match="here <c>"):
        XML.number(ROOT, "c", 5.0, "here")
    assert XML.attribute_number(ROOT, "n", "3", "here") == 7.0
    assert XML.attribute_number(ROOT, "none", "3", "here") == 3.0
    with pytest.raises(WorldError, match="here long"):
        XML.attribute_number(ROOT, "long", "3", "here")
    assert XML.child(ROOT, "b", "here").text == "2.9"
    with refused("<a> lacks <none>"):
        XML.child(ROOT, "none", "here")


def test_texts_are_there_and_no_longer_than_a_thousand_characters() -> None:
    assert XML.attribute(ROOT, "n", "here") == "7"
    for name in ("none", "blank"):
        with refused(f"<a> lacks the attribute '{name}'"):
            XML.attribute(ROOT, name, "here")
    with refused("the attribute 'long' has 1001 characters; valid: up to 1000"):
        XML.attribute(ROOT, "long", "here")
    edge = file("<a n='{}'/>".format("y" * 1000))
    assert len(edge.attribute(edge.root[0], "n", "here")) == 1000
    named = "<sdf name='{}'/>"
    XmlFile(Path("w.sdf"), "sdf", WorldError, named.format("n" * 1000).encode())
    with refused("has a name of more than 1000 characters"):
        XmlFile(Path("w.sdf"), "sdf", WorldError, named.format("n" * 1001).encode())


def test_an_error_says_why_a_file_is_invalid() -> None:
    with refused("has the root <sdf>; valid: <robot>"):
        file(tag="robot")
    with pytest.raises(WorldError, match=r"line 2.*is broken XML|is broken XML.*line 2"):
        XmlFile(Path("w.sdf"), "sdf", WorldError, b"<sdf>\n<a></sdf>")


def test_a_topic_below_an_empty_namespace_is_one() -> None:
    """As `/$(arg namespace)/imu` is without the argument; other texts stay."""
    root = file("<topicName>//a///b</topicName><uri>file:///a</uri>").root
    assert [child.text for child in root] == ["/a/b", "file:///a"]


def test_the_namespace_of_all_tags_is_none() -> None:
    text = b"<sdf xmlns='http://a.b/c' xmlns:x='http://x'><link name='l'/><x:link/></sdf>"
    xml = XmlFile(Path("w.sdf"), "sdf", WorldError, text)
    assert [element.tag for element in xml.root] == ["link", "{http://x}link"]


def test_notes_are_kept_once_in_their_order() -> None:
    xml = file()
    for text in ("one", "two", "one"):
        xml.note(text)
    xml.note("one", NoteKind.BROKEN)
    expected = [(NoteKind.CHANGED, "one"), (NoteKind.CHANGED, "two"), (NoteKind.BROKEN, "one")]
    assert list(xml.notes) == [Note(kind, text) for kind, text in expected]


def nested(depth: int) -> bytes:
    return b"<a>" * depth + b"</a>" * depth


def test_elements_are_nested_so_deep_and_no_deeper() -> None:
    assert len(list(parse_xml("f", nested(DEPTH_MAX)).iter())) == DEPTH_MAX
    side_by_side = b"<r>" + nested(DEPTH_MAX - 1) * 2 + b"</r>"
    assert len(parse_xml("f", side_by_side)) == 2
    with pytest.raises(InputFileError, match=f"or more than {DEPTH_MAX} nested"):
        parse_xml("f", side_by_side.replace(b"</r>", nested(DEPTH_MAX) + b"</r>"))


def test_attributes_hold_signs_that_xml_would_have_escaped() -> None:
    part = parse_xml("f", b"<a><b c = 'x < 1 && &y;' d=\"&lt;&#38;it's\"/>1 = 'p'</a>")[0]
    assert part.attrib == {"c": "x < 1 && &y;", "d": "<&it's"}


@pytest.mark.parametrize(
    "start", [b"<?xml version='1.0'>", b"\n<?xml version='1.0' encoding='utf-8' >"]
)
def test_a_declaration_may_end_like_a_tag(start: bytes) -> None:
    assert parse_xml("f", start + b"\n<a b='?'><!-- <?xml> --></a>").attrib == {"b": "?"}
