"""A campaign's results: a table as Parquet, a page that shows them, and what a paper prints.

But for the Parquet table, which has the wall time of runs, all of it is the same, byte for byte,
wherever and in which order the runs were run.
"""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from arjuna_core.files.whole_file import write_atomically
from bringup.campaign.comparison import (
    Pairs,
    discordant,
    estimate,
    figures,
    paired_difference,
    wilson_interval,
)
from bringup.campaign.outcome import Outcome, read_outcome
from bringup.campaign.plan import Campaign, CampaignError

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


if TYPE_CHECKING:
    from bringup.campaign.pictures import Groups

TABLE, PAGE, PAPER = "results.parquet", "index.html", "paper"
STYLE = (
    "body{font:16px sans-serif;max-width:75em;margin:2em auto;padding:0 1em}"
    "table{border-collapse:collapse;font-size:.9em}"
    "td,th{padding:.2em .7em;text-align:left;white-space:nowrap}"
    "tr:nth-child(even){background:#f2f2f2}img{max-width:100%}.bad{color:#b00}"
    "figure{display:inline-block;margin:.5em;width:15em}figure img{width:15em}"
    "div{overflow-x:auto}"
)
_METHODS = (
    "Intervals hold with 95 %: of successes Wilson's, of means and of differences, which are taken "
    "pair by pair, the bootstrap's (bias-corrected and accelerated; none of fewer than six). * "
    "marks a difference whose interval leaves out 0. 'Only' counts pairs in which one run alone "
    "succeeded; p is McNemar's, that chance makes them so unequal. Boxes reach from the lower to "
    "the upper quartile, whiskers at most 1.5 times as far; red dots are runs that failed."
)


def write_table(folder: Path, outcomes: Sequence[Outcome]) -> None:
    """Write the outcomes as Parquet: a row a run, a column a factor and a figure.

    Raises:
        OSError: It cannot be written.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    rows = [
        {"run": one.name, **one.levels, "success": one.success, "reason": one.reason,
         "wall_s": one.wall_s, **one.figures}
        for one in outcomes
    ]  # fmt: skip
    columns = dict.fromkeys(key for row in rows for key in row)
    table = pa.table({key: [row.get(key) for row in rows] for key in columns})
    buffer = io.BytesIO()
    pq.write_table(table, buffer)
    write_atomically(folder / TABLE, buffer.getvalue())


def page_of(title: str, parts: Iterable[str], refresh: int = 0) -> str:
    """Return a page of HTML.

    Args:
        title: Its title and heading, as text.
        parts: What is below, as HTML.
        refresh: After which it is loaded again [s]; 0 for never.
    """
    title, again = html.escape(title), f"<meta http-equiv=refresh content={refresh}>"
    head = f"{again if refresh else ''}<title>{title}</title><style>{STYLE}</style>"
    return "\n".join([f"<!doctype html><meta charset=utf-8>{head}", f"<h1>{title}</h1>", *parts])


def write_page(folder: Path, campaign: Campaign, outcomes: Sequence[Outcome]) -> None:
    """Write the page, and into a folder beside it what a paper prints: tables and pictures.

    Raises:
        OSError: It cannot be written.
    """
    from bringup.campaign.pictures import pictures_of

    paper = folder / PAPER
    parts = [f"<p><code>{html.escape(' '.join(campaign.command))}</code></p>"]
    for name, heading, table in _tables(campaign, outcomes):
        write_atomically(paper / f"{name}.md", table.markdown().encode())
        write_atomically(paper / f"{name}.tex", table.latex().encode())
        parts.append(f"<h2>{heading}</h2><div>{table.html()}</div>")
    parts += [f"<p>{_METHODS}</p>", "<h2>Pictures</h2>"]
    measures = _measures(campaign, outcomes)
    for name, png, pdf in pictures_of(campaign, _groups(campaign, outcomes), measures):
        write_atomically(paper / f"{name}.pdf", pdf)
        data = base64.b64encode(png).decode()
        parts.append(f'<img alt="{html.escape(name)}" src="data:image/png;base64,{data}">')
    parts += ["<h2>Runs that failed</h2>", *_failed(folder, outcomes)]
    write_atomically(folder / PAGE, page_of(f"Campaign {campaign.name}", parts).encode())


def share_text(outcomes: Sequence[Outcome]) -> tuple[str, str, str]:
    """Return how many runs there are, the share that succeeded and its 95 % interval."""
    good = sum(one.success for one in outcomes)
    low, high = wilson_interval(good, len(outcomes))
    share = f"{good} of {len(outcomes)}"
    return f"{len(outcomes)}", share, f"{100.0 * low:.1f} to {100.0 * high:.1f} %"


def _measures(campaign: Campaign, outcomes: Sequence[Outcome]) -> list[str]:
    """Return the keys of the figures to show: those asked for, or all."""
    found = dict.fromkeys(key for one in outcomes for key in one.figures)
    return [key for key in campaign.measures or found if key in found]


def _groups(campaign: Campaign, outcomes: Sequence[Outcome]) -> Groups:
    """Return all outcomes, and those of each level of each condition, by name."""
    found: Groups = {"all runs": outcomes}
    for factor in campaign.conditions:
        for level in campaign.factors[factor]:
            name = level.label if len(campaign.conditions) == 1 else f"{factor} {level.label}"
            found[name] = [one for one in outcomes if one.levels[factor] == level.label]
    return {name: chosen for name, chosen in found.items() if chosen}


def _tables(campaign: Campaign, outcomes: Sequence[Outcome]) -> Iterator[tuple[str, str, Table]]:
    """Yield tables, each with its file's name and its heading."""
    groups, measures = _groups(campaign, outcomes), _measures(campaign, outcomes)
    conditions, compare = campaign.conditions, campaign.compare
    names = [conditions[0] if len(conditions) == 1 else "", *([compare] if compare else [])]
    rows = [
        [name, *label, *share_text(part), *[str(estimate(figures(part, key))) for key in measures]]
        for name, chosen in groups.items()
        for label, part in _parts(campaign, chosen)
    ]
    head = [*names, "runs", "success", "95 % interval", *measures]
    yield "results", "Results", Table(head, rows, len(names))
    labels = [level.label for level in campaign.factors.get(compare, ())]
    if len(labels) < 2:
        return
    base, *others = labels
    rows = [
        [name, other, f"{len(pairs)}", *_difference(pairs, measures)]
        for name, chosen in groups.items()
        for other in others
        if (pairs := _pairs(compare, chosen, base, other))
    ]
    head = [*names, "pairs", f"only {base}", "only this", "p", *measures]
    yield "differences", f"Differences from {html.escape(base)}", Table(head, rows, len(names))


def _parts(
    campaign: Campaign, outcomes: Sequence[Outcome]
) -> Iterator[tuple[list[str], Sequence[Outcome]]]:
    """Yield the outcomes of each level that is compared, with its label; all if none is."""
    if not campaign.compare:
        yield [], outcomes
        return
    for level in campaign.factors[campaign.compare]:
        part = [one for one in outcomes if one.levels[campaign.compare] == level.label]
        if part:
            yield [level.label], part


def _pairs(factor: str, outcomes: Sequence[Outcome], base: str, other: str) -> Pairs:
    """Return the runs of two levels of a factor that differ in nothing else."""
    found = {frozenset(one.levels.items()): one for one in outcomes}
    pairs = ((one, {**one.levels, factor: other}) for one in outcomes if one.levels[factor] == base)
    return [
        (one, found[levels])
        for one, changed in pairs
        if (levels := frozenset(changed.items())) in found
    ]


def _difference(pairs: Pairs, measures: Sequence[str]) -> list[str]:
    first, second, chance = discordant(pairs)
    found = [paired_difference(pairs, key) for key in measures]
    marked = [f"{one}{' *' if one.significant else ''}" for one in found]
    return [f"{first}", f"{second}", f"{chance:.3f}", *marked]


def _failed(folder: Path, outcomes: Sequence[Outcome]) -> Iterator[str]:
    """Yield what shows each run that failed: why, its pictures and its recordings."""
    failed = [one for one in outcomes if not one.success]
    if not failed:
        yield "<p>None.</p>"
        return
    yield (
        f"<p>{len(failed)} of {len(outcomes)}. <code>python -m bringup replay FILE.mcap</code> "
        "shows a recording in rerun's viewer, and <code>--save FILE.rrd</code> writes it so.</p>"
    )
    for one in failed:
        name, files = html.escape(one.name), sorted((folder / one.name).glob("*"))
        links = ", ".join(
            f'<a href="{name}/{html.escape(file.name)}">{html.escape(file.name)}</a>'
            for file in files
            if file.suffix in (".mcap", ".rrd")
        )
        yield (
            f'<p><a href="{name}/">{name}</a>: <span class="bad">{html.escape(one.reason)}</span>'
            f"{'; ' if links else ''}{links}</p>"
        )
        for file in files:
            if file.suffix == ".png":
                path = f"{name}/{html.escape(file.name)}"
                yield (
                    f'<figure><a href="{path}"><img loading=lazy alt="{path}" src="{path}"></a>'
                    f"<figcaption>{html.escape(file.name)}</figcaption></figure>"
                )


def outcomes_in(folder: Path) -> list[Outcome]:
    """Return the outcomes of a campaign's folder, in the order of its runs.

    Raises:
        CampaignError: It holds none.
    """
    paths = sorted(folder.iterdir()) if folder.is_dir() else []
    outcomes = [one for one in map(read_outcome, paths) if one is not None]
    if not outcomes:
        raise CampaignError(folder, "holds no runs; valid: the folder that a campaign wrote")
    return outcomes
