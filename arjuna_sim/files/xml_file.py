"""Reading URDF and SDF: hardened XML, and numbers whose errors name the file and the element."""

from __future__ import annotations

import math
import re
from pathlib import Path
from xml.etree.ElementTree import Element  # a type alone

from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import read_bytes
from arjuna_core.files.xml_text import parse_xml, without_comments
from arjuna_sim.files import before_sdf
from arjuna_sim.files.search_path import EscapeError, SearchPath
from arjuna_sim.model.geometry.shapes import Mesh, Terrain
from arjuna_sim.model.notes import Note, NoteKind

BYTES_MAX = 20_000_000  # a hostile file still loads within 2 s and 500 MB
UNLIMITED = 1e6
"""A joint's limit beyond it is none [rad or m]; SDF writes 1e16 for a joint without limits."""
_TEXT_MAX = 1000
_SIZE_MAX = 1e5  # [m]
_POSITION_MAX = 1e6  # [m]


def root_tag(text: bytes) -> str:
    """Return whether a text holds `sdf` or `robot`, by whichever tag is first; "" for neither.

    What its comments speak of does not count.
    """
    root = re.search(rb"<\s*(sdf|robot)\b", without_comments(text))
    return root.group(1).decode() if root is not None else ""


def _drop_namespace(root: Element) -> None:
    """Take off the namespace that a file has for all tags without a prefix, as its readers do."""
    space, _, _ = root.tag.rpartition("}")
    for element in root.iter() if space else ():
        element.tag = element.tag.removeprefix(f"{space}}}")


def _join_slashes(root: Element) -> None:
    """Make `/$(arg namespace)/scan` a topic without a namespace too, as Gazebo's transport does."""
    for element in root.iter():
        if "topic" in element.tag.lower() and "//" in (element.text or ""):
            element.text = re.sub("//+", "/", element.text or "")


class XmlFile:
    """A parsed file, and the helpers that turn its text into values.

    Args:
        tag: The tag its root must have.
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
        self.text = read_bytes(path, BYTES_MAX, error) if text is None else text
        self.root = self._parse(tag)
        self.search = SearchPath.of() if search is None else search
        self.beside: tuple[Path, ...] = (path,)
        self.meshes: dict[Path, Mesh] = {}
        self.terrains: dict[Path, Terrain] = {}
        self.notes: dict[Note, None] = {}

    def _parse(self, tag: str) -> Element:
        root = parse_xml(self.path, self.text, self.error)
        _drop_namespace(root)
        _join_slashes(root)
        if len(root.get("name", "")) > _TEXT_MAX:
            raise self.error(self.path, f"has a name of more than {_TEXT_MAX} characters")
        if root.tag == before_sdf.ROOT and tag == "sdf":
            before_sdf.to_sdf(root)
        if root.tag != tag:
            raise self.error(self.path, f"has the root <{root.tag}>; valid: <{tag}>")
        return root

    def fail(self, label: str, problem: str) -> InputFileError:
        """Return the exception to raise for an element of this file."""
        return self.error(self.path, problem, label)

    def note(self, text: str, kind: NoteKind = NoteKind.CHANGED, of: str = "") -> None:
        """Keep one line on what is not simulated as the file says it."""
        self.keep(Note(kind, text, of))

    def keep(self, *notes: Note) -> None:
        """Keep notes, each once."""
        self.notes.update(dict.fromkeys(notes))

    def find(self, uri: str, label: str) -> Path | None:
        """Return the file that a path or URI of this file, or of one it includes, leads to.

        Raises:
            InputFileError: It leads out of its package, model or folder.
        """
        try:
            found = (self.search.find(file, uri) for file in self.beside)
            return next((path for path in found if path is not None), None)
        except EscapeError as error:
            raise self.fail(label, str(error)) from error

    def find_model(self, uri: str, label: str) -> Path | None:
        """Return the SDF file of a model that this file includes, None where there is none.

        Raises:
            InputFileError: It leads out of its package, model or folder.
        """
        try:
            return self.search.find_model(self.path, uri)
        except EscapeError as error:
            raise self.fail(label, str(error)) from error

    def beside_it(self, path: Path) -> XmlFile:
        """Return another file of the same kind, which shares this one's notes and meshes.

        Raises:
            InputFileError: It is missing, too large, broken or unsafe XML.
        """
        other = XmlFile(path, self.root.tag, self.error, search=self.search)
        other.meshes, other.terrains, other.notes = self.meshes, self.terrains, self.notes
        return other

    def attribute(self, element: Element, name: str, label: str) -> str:
        """Return an attribute that must be there."""
        value = element.get(name)
        if value is None or not value.strip():
            raise self.fail(label, f"<{element.tag}> lacks the attribute '{name}'")
        if len(value) > _TEXT_MAX:
            problem = (
                f"the attribute '{name}' has {len(value)} characters; valid: up to {_TEXT_MAX}"
            )
            raise self.fail(f"<{element.tag}>", problem)
        return value.strip()

    def child(self, element: Element, path: str, label: str) -> Element:
        """Return a child that must be there."""
        found = element.find(path)
        if found is None:
            raise self.fail(label, f"<{element.tag}> lacks <{path}>")
        return found

    def numbers(self, text: str, count: int, label: str) -> tuple[float, ...]:
        """Return `count` finite numbers of a text."""
        words = text.split()
        if len(words) != count:
            raise self.fail(label, f"has {len(words)} numbers ({text!r}); valid: {count}")
        try:
            values = tuple(float(word) for word in words)
        except ValueError as error:
            raise self.fail(label, f"{text!r} is not {count} numbers") from error
        if not all(math.isfinite(value) for value in values):
            raise self.fail(label, f"{text!r} must be finite")
        return values

    def attribute_number(self, element: Element, name: str, default: str, label: str) -> float:
        """Return the finite number in an attribute, or in the default where it is not there."""
        return self.numbers(element.get(name, default), 1, f"{label} {name}")[0]

    def limit(self, text: str | None, default: float, label: str) -> float:
        """Return the limit of a joint, the default where there is no text; it may be infinite.

        What is infinite is replaced by the largest limit that is simulated.
        """
        try:
            value = default if text is None else float(text)
        except ValueError:
            value = math.nan
        if math.isnan(value):
            raise self.fail(label, f"{text!r} is no number; valid: as 1.57, or inf for no stop")
        return min(max(value, -UNLIMITED), UNLIMITED)

    def sizes(self, text: str, count: int, label: str) -> tuple[float, ...]:
        """Return `count` lengths above zero, of which none is larger than a landscape."""
        values = self.numbers(text, count, label)
        if min(values) <= 0.0:
            raise self.fail(label, f"{text!r} must be above zero")
        if max(values) > _SIZE_MAX:
            raise self.fail(label, f"{text!r} is too large; valid: up to {_SIZE_MAX:g}")
        return values

    def position(self, text: str, label: str) -> tuple[float, ...]:
        """Return three coordinates within reach."""
        values = self.numbers(text, 3, label)
        if max(map(abs, values)) > _POSITION_MAX:
            raise self.fail(label, f"{text!r} is too far; valid: up to {_POSITION_MAX:g}")
        return values

    def count(self, element: Element | None, path: str, default: int, label: str) -> int:
        """Return the number in a child's text cut to a whole one, or the default."""
        value = self.number(element, path, default, label)
        if abs(value) > _POSITION_MAX:
            raise self.fail(f"{label} <{path}>", f"{value:g} is too large")
        return int(value)

    def number(self, element: Element | None, path: str, default: float, label: str) -> float:
        """Return the number in a child's text, or the default where there is no such child."""
        text = None if element is None else element.findtext(path)
        if text is None:
            return default
        return self.numbers(text, 1, f"{label} <{path}>")[0]
