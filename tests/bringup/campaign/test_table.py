"""Tables: what a page, a text and LaTeX make of the same cells."""

from __future__ import annotations

import re

from bringup.campaign.table import Table

TABLE = Table(
    ("scene", "time_per_metre_s", "100 %"),
    [("a & b", "1.0 [0.9, 1.1] *", r"C:\x"), ("<50 {m}", "$5", "~^#|"), ("", "[2]", "two\nlines")],
)
_COMMAND = re.compile(r"\\(?:[a-zA-Z]+\{\}|[&%$#_{}])")


def printed(cell: str) -> str:
    """Return what LaTeX prints of a cell; what it would take for a command of its own fails."""
    names = {
        r"\textbackslash{}": "\\",
        r"\textless{}": "<",
        r"\textgreater{}": ">",
        r"\textasciitilde{}": "~",
        r"\textasciicircum{}": "^",
    }
    cell = re.sub(r"^\{\}", "", cell)
    assert not re.search(r"[&%$#_{}~^<>\\]", _COMMAND.sub("", cell))
    return _COMMAND.sub(lambda one: names.get(one[0], one[0][1:]), cell)


def parsed(text: str) -> tuple[str, list[list[str]]]:
    """Return the columns and the rows of a tabular."""
    begin, *lines, end, _ = text.split("\n")
    found = re.fullmatch(r"\\begin\{tabular\}\{([lr]+)\}", begin)
    assert found is not None
    assert (lines[0], lines[2], lines[-1]) == (r"\toprule", r"\midrule", r"\bottomrule")
    assert end == r"\end{tabular}"
    rows = [line for line in lines if line not in (r"\toprule", r"\midrule", r"\bottomrule")]
    assert all(row.endswith(r" \\") for row in rows)
    cells = [re.split(r"(?<!\\)&", row.removesuffix(r" \\")) for row in rows]
    return found[1], [[printed(cell.strip()) for cell in row] for row in cells]


def test_latex_prints_every_cell_in_its_column() -> None:
    columns, rows = parsed(TABLE.latex())
    assert columns == "lrr"
    assert rows == [[" ".join(cell.split()) for cell in row] for row in (TABLE.head, *TABLE.rows)]


def test_no_row_begins_with_what_ends_a_line_s_options() -> None:
    text = Table(("a",), [("[1]",), ("* b",)]).latex()
    assert not re.search(r"\\\\\n[\[*]", text)


def test_markdown_has_a_line_a_row_and_as_many_cells_in_each() -> None:
    lines = TABLE.markdown().splitlines()
    assert lines[1] == "| :-- | --: | --: |"
    assert len(lines) == 5
    assert {len(re.findall(r"(?<!\\)\|", line)) for line in lines} == {4}


def test_a_page_shows_cells_as_they_are() -> None:
    assert "<td>&lt;50 {m}</td>" in TABLE.html()
