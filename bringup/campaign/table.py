"""Tables for a page, for a text and for a paper."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

_LATEX = {
    **{sign: f"\\{sign}" for sign in "&%$#_{}"},
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "\\": r"\textbackslash{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
}


@dataclass(frozen=True)
class Table:
    """Rows of text below a head.

    Attributes:
        names: How many of the first columns hold names; the others hold figures.
    """

    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    names: int = 1

    def html(self) -> str:
        """Return it as an element of a page."""
        lines = ["".join(f"<th>{html.escape(cell)}</th>" for cell in self.head)]
        lines += ["".join(f"<td>{html.escape(cell)}</td>" for cell in row) for row in self.rows]
        return "<table>" + "".join(f"<tr>{line}</tr>" for line in lines) + "</table>"

    def markdown(self) -> str:
        """Return it as lines of Markdown."""
        sides = [":--" if k < self.names else "--:" for k in range(len(self.head))]
        rows = [[_one_line(cell).replace("|", r"\|") for cell in row] for row in self._all()]
        rows.insert(1, sides)
        return "".join(f"| {' | '.join(row)} |\n" for row in rows)

    def latex(self) -> str:
        """Return it as a tabular with the rules of the package booktabs."""
        columns = "l" * self.names + "r" * (len(self.head) - self.names)
        head, *rows = (f"{' & '.join(map(_escaped, row))} \\\\" for row in self._all())
        lines = [rf"\begin{{tabular}}{{{columns}}}", r"\toprule", head, r"\midrule", *rows]
        return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", ""])

    def _all(self) -> Iterable[Sequence[str]]:
        return (self.head, *self.rows)


def _one_line(text: str) -> str:
    return " ".join(text.split())


def _escaped(text: str) -> str:
    """Return a text as LaTeX prints it; a bracket after a line's end would be its argument."""
    found = "".join(_LATEX.get(sign, sign) for sign in _one_line(text))
    return f"{{}}{found}" if found.startswith(("[", "*")) else found
