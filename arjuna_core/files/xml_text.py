"""XML of anyone, parsed within bounds: no DTD, no entities, and one error for all that is wrong."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree.ElementTree import Element, ParseError, TreeBuilder  # parsing is defusedxml's
from xml.parsers.expat import errors

from defusedxml import DefusedXmlException
from defusedxml.ElementTree import DefusedXMLParser

from arjuna_core.errors import InputFileError

# Bounds on hostile files: what still loads within 2 s and 500 MB (tests/fuzz/test_models.py).
_ELEMENTS_MAX = 300_000
DEPTH_MAX = 100
"""Of what a file nests: elements, or links and frames, one below another."""
_PREFIX = re.compile(rb"[<\s/]([A-Za-z_][\w.-]*):[A-Za-z_]")
_DECLARED = re.compile(rb"xmlns:([A-Za-z_][\w.-]*)\s*=")
_OPEN = re.compile(rb"(<\?xml[^?>]*)>")
_ROOT = re.compile(rb"<[A-Za-z_][\w.-]*")
_TEMPLATES = {b"<": "ERB", b"{": "Jinja", b"@": "EmPy"}
_TEMPLATE = re.compile(rb"<%|\{%|@\[(for|if)\b")
_PAGE = re.compile(rb"\s*<(!doctype\s+)?html\b", re.IGNORECASE)
_CUT_OFF = (
    errors.codes[errors.XML_ERROR_NO_ELEMENTS],
    errors.codes[errors.XML_ERROR_UNCLOSED_TOKEN],
)
_VALUE = re.compile(rb"""=\s*("[^"]*"|'[^']*')""")
_BARE = re.compile(rb"&(?!(?:amp|lt|gt|quot|apos|#\w+);)")
_OPENS, _CLOSES = b"<!--", b"-->"
_WESTERN = "cp1252"  # in which files are written that are not in UTF-8 and do not say so


class _Builder(TreeBuilder):
    def __init__(self) -> None:
        super().__init__()
        self._count = self._depth = 0

    def start(self, tag: str, attributes: dict[str, str], /) -> Element:
        self._count += 1
        self._depth += 1
        if self._count > _ELEMENTS_MAX or self._depth > DEPTH_MAX:
            problem = f"it has more than {_ELEMENTS_MAX} elements, or more than {DEPTH_MAX} nested"
            raise ValueError(problem)
        return super().start(tag, attributes)

    def end(self, tag: str, /) -> Element:
        self._depth -= 1
        return super().end(tag)


def parse_xml(
    path: str | Path, text: bytes, error: type[InputFileError] = InputFileError
) -> Element:
    """Parse plain XML: no DTD, no entities, no more elements than any robot or world has.

    As for the parser of Gazebo and BehaviorTree.CPP, a prefix that nobody declares stands for
    itself, blanks may stand before the declaration, which may end in ">" alone, a comment may hold
    two dashes, an attribute "<" and "&" as they are (in scripts of trees), and letters need not be
    UTF-8.

    Args:
        path: Where the text is from, for messages.

    Raises:
        InputFileError: It is broken, unsafe or too large, or its encoding is unknown; of the kind
            given as `error`.
    """
    if not text.strip():
        raise error(path, "is empty; valid: XML")
    if _PAGE.match(text):
        raise error(path, "is a web page that was saved in its place; download the file itself")
    if _TEMPLATE.search(text) and (mark := _TEMPLATE.search(without_comments(text))):
        tool, line = _TEMPLATES[mark[0][:1]], text.count(b"\n", 0, text.find(mark[0])) + 1
        raise error(path, f"is a template: load what {tool} makes of it", f"line {line}")
    try:
        try:
            return _parse(text)
        except ParseError:
            mended = _OPEN.sub(rb"\1?>", without_comments(text), count=1)
            mended = _declared(_escaped(_in_utf8(mended)))
        return _parse(mended)
    except ParseError as reason:
        is_cut_off = reason.code in _CUT_OFF
        rest = "; it ends too early: fetch or save it again" if is_cut_off else ""
        problem = f"is broken XML: {reason.msg}{rest}"
        if b"<" not in text.lstrip()[:4]:  # the first ones may be a byte order mark
            problem = f"is no XML: it begins with {text[:20].decode(errors='replace')!r}"
        raise error(path, problem, f"line {reason.position[0]}") from reason
    except DefusedXmlException as reason:
        problem = f"declares a DTD or entities ({type(reason).__name__}); plain XML is valid"
        raise error(path, problem) from reason
    except (ValueError, LookupError) as reason:
        raise error(path, f"is no readable XML: {reason}") from reason


def _parse(text: bytes) -> Element:
    parser = DefusedXMLParser(target=_Builder(), forbid_dtd=True)
    parser.feed(text.lstrip() if text.lstrip().startswith(b"<?xml") else text)
    root: Element = parser.close()
    return root


def without_comments(text: bytes) -> bytes:
    """Return a text of as many lines without its comments, in time linear in it."""
    pieces, at = [], 0
    while (start := text.find(_OPENS, at)) >= 0:
        end = text.find(_CLOSES, start + len(_OPENS))
        if end < 0:
            break
        pieces.append(text[at:start] + b"\n" * text.count(b"\n", start, end))
        at = end + len(_CLOSES)
    return b"".join((*pieces, text[at:]))


def _in_utf8(text: bytes) -> bytes:
    """Return a text in UTF-8 that was in nothing that it says."""
    try:
        text.decode("utf-8")
    except UnicodeDecodeError:
        return text.decode(_WESTERN, "replace").encode("utf-8")
    return text


def _escaped(text: bytes) -> bytes:
    def escape(value: re.Match[bytes]) -> bytes:
        return _BARE.sub(b"&amp;", value.group()).replace(b"<", b"&lt;")

    return _VALUE.sub(escape, text)


def _declared(text: bytes) -> bytes:
    prefixes = sorted(set(_PREFIX.findall(text)) - set(_DECLARED.findall(text)))
    declared = b"".join(b" xmlns:%b='%b'" % (prefix, prefix) for prefix in prefixes[:20])
    return _ROOT.sub(lambda found: found.group() + declared, text, count=1)
