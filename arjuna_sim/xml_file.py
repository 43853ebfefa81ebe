"""Reading URDF and SDF: hardened XML, and numbers whose errors name the file and the place."""

from __future__ import annotations

import math
from pathlib import Path
from xml.etree.ElementTree import Element, ParseError  # types only; parsing is defusedxml's

from defusedxml import DefusedXmlException
from defusedxml.ElementTree import fromstring

from arjuna_core.errors import InputFileError
from arjuna_sim.resources import SearchPath

_BYTES_MAX = 20_000_000


def read_bytes(path: Path, error: type[InputFileError]) -> bytes:
    """Return a file's content.

    Raises:
        InputFileError: As `error`: the file is missing or too large.
    """
    try:
        text = path.read_bytes()
    except OSError as cause:
        raise error(path, f"cannot be read: {cause.strerror}") from cause
    if len(text) > _BYTES_MAX:
        raise error(path, f"has {len(text)} bytes; at most {_BYTES_MAX} are read")
    return text


class XmlFile:
    """A parsed file, and the helpers that turn its text into values.

    Args:
        path: The file.
        tag: The tag its root must have.
        error: The exception to raise.
        text: The content, where it does not come from the file itself.
        search: Where to look for what the file refers to; the environment's folders if None.

    Raises:
        InputFileError: As `error`: the file is missing, too large, broken or unsafe XML.
    """

    def __init__(
        self,
        path: Path,
        tag: str,
        error: type[InputFileError],
        text: bytes | None = None,
        search: SearchPath | None = None,
    ) -> None:
        self.path = path
        self.error = error
        self.text = read_bytes(path, error) if text is None else text
        self.root = self._parse(tag)
        self.search = SearchPath.of() if search is None else search
        self.included: tuple[Path, ...] = (path.resolve(),)
        self.notes: list[str] = []

    def _parse(self, tag: str) -> Element:
        try:
            root: Element = fromstring(self.text, forbid_dtd=True)
        except ParseError as error:
            line = f"line {error.position[0]}"
            raise self.error(self.path, f"is broken XML: {error.msg}", line) from error
        except DefusedXmlException as error:
            problem = f"declares a DTD or entities ({type(error).__name__}); plain XML is valid"
            raise self.error(self.path, problem) from error
        except (ValueError, LookupError) as error:
            raise self.error(self.path, f"is no readable XML: {error}") from error
        if root.tag != tag:
            raise self.error(self.path, f"has the root <{root.tag}>; valid: <{tag}>")
        return root

    def fail(self, place: str, problem: str) -> InputFileError:
        """Return the exception to raise for a place in this file."""
        return self.error(self.path, problem, place)

    def note(self, text: str) -> None:
        """Keep one line on what was read but is not simulated."""
        if text not in self.notes:
            self.notes.append(text)

    def attribute(self, element: Element, name: str, place: str) -> str:
        """Return an attribute that must be there."""
        value = element.get(name)
        if value is None or not value.strip():
            raise self.fail(place, f"<{element.tag}> lacks the attribute '{name}'")
        return value.strip()

    def child(self, element: Element, path: str, place: str) -> Element:
        """Return a child that must be there."""
        found = element.find(path)
        if found is None:
            raise self.fail(place, f"<{element.tag}> lacks <{path}>")
        return found

    def numbers(self, text: str, count: int, place: str) -> tuple[float, ...]:
        """Return `count` finite numbers of a text."""
        words = text.split()
        if len(words) != count:
            raise self.fail(place, f"has {len(words)} numbers ({text!r}); valid: {count}")
        try:
            values = tuple(float(word) for word in words)
        except ValueError as error:
            raise self.fail(place, f"{text!r} is not {count} numbers") from error
        if not all(math.isfinite(value) for value in values):
            raise self.fail(place, f"{text!r} must be finite")
        return values

    def positive(self, text: str, count: int, place: str) -> tuple[float, ...]:
        """Return `count` finite numbers above zero."""
        values = self.numbers(text, count, place)
        if min(values) <= 0.0:
            raise self.fail(place, f"{text!r} must be above zero")
        return values

    def number(self, element: Element | None, path: str, default: float, place: str) -> float:
        """Return the number in a child's text, or the default where there is no such child."""
        text = None if element is None else element.findtext(path)
        if text is None:
            return default
        return self.numbers(text, 1, f"{place} <{path}>")[0]
