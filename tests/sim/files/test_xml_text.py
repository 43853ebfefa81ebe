"""How deep XML may be nested."""

from __future__ import annotations

import pytest

from arjuna_sim.files.xml_file import _DEPTH_MAX, parse_xml


def nested(depth: int) -> bytes:
    return b"<a>" * depth + b"</a>" * depth


def test_elements_are_nested_so_deep_and_no_deeper() -> None:
    assert len(list(parse_xml(nested(_DEPTH_MAX)).iter())) == _DEPTH_MAX
    side_by_side = b"<r>" + nested(_DEPTH_MAX - 1) * 2 + b"</r>"
    assert len(parse_xml(side_by_side)) == 2
    with pytest.raises(ValueError, match=f"or more than {_DEPTH_MAX} nested"):
        parse_xml(nested(_DEPTH_MAX + 1))
