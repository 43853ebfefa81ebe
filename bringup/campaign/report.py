"""A campaign's results: a table as Parquet, and a page that shows it."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Iterable, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from scipy import stats

from arjuna_core.files.whole_file import write_atomically
from bringup.campaign.outcome import Outcome, read_outcome
from bringup.campaign.plan import Campaign, CampaignError

mpl.use("Agg")
TABLE, PAGE = "results.parquet", "index.html"
_STYLE = (
    "body{font:16px sans-serif;max-width:60em;margin:2em auto}td,th{padding:.2em .8em;text-align:"
    "left}tr:nth-child(even){background:#f2f2f2}img{width:20em}.bad{color:#b00}"
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


def write_page(folder: Path, campaign: Campaign, outcomes: Sequence[Outcome]) -> None:
    """Write one page with the share of successes, by factor too, the figures and the worst runs.

    Raises:
        OSError: It cannot be written.
    """
    title = html.escape(f"Campaign {campaign.name}")
    parts = [
        f"<!doctype html><meta charset=utf-8><title>{title}</title><style>{_STYLE}</style>",
        f"<h1>{title}</h1><p><code>{html.escape(' '.join(campaign.command))}</code></p>",
        _table(("", "runs", "success", "95 % interval"), _shares(campaign, outcomes)),
        "<h2>Figures</h2>",
        *_histograms(campaign, outcomes),
        "<h2>Runs that failed, the longest first</h2>",
        _failed(outcomes),
    ]
    write_atomically(folder / PAGE, "\n".join(parts).encode())


def share_text(outcomes: Sequence[Outcome]) -> tuple[str, str, str]:
    """Return how many runs there are, the share that succeeded and its 95 % interval."""
    good = sum(one.success for one in outcomes)
    low, high = wilson_interval(good, len(outcomes))
    share = f"{good} of {len(outcomes)}"
    return f"{len(outcomes)}", share, f"{100.0 * low:.1f} to {100.0 * high:.1f} %"


def _shares(campaign: Campaign, outcomes: Sequence[Outcome]) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = [("all", *share_text(outcomes))]
    for factor, levels in campaign.factors.items():
        if 1 < len(levels) <= len(outcomes) // 2:  # else each level says next to nothing
            rows += [
                (f"{factor} {level.label}", *share_text(chosen))
                for level in levels
                if (chosen := [one for one in outcomes if one.levels[factor] == level.label])
            ]
    return rows


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = ["".join(f"<th>{html.escape(cell)}</th>" for cell in head)]
    lines += ["".join(f"<td>{html.escape(cell)}</td>" for cell in row) for row in rows]
    return "<table>" + "".join(f"<tr>{line}</tr>" for line in lines) + "</table>"


def measures_of(campaign: Campaign, outcomes: Sequence[Outcome]) -> list[str]:
    """Return the keys of the figures to show: those asked for, or all."""
    found = dict.fromkeys(key for one in outcomes for key in one.figures)
    return [key for key in campaign.measures or found if key in found]


def _histograms(campaign: Campaign, outcomes: Sequence[Outcome]) -> list[str]:
    return [
        _histogram(key, [one.figures[key] for one in outcomes if key in one.figures])
        for key in measures_of(campaign, outcomes)
    ]


def _histogram(key: str, values: Sequence[float]) -> str:
    finite = np.array([value for value in values if np.isfinite(value)])
    figure = Figure(figsize=(4.0, 2.6), layout="constrained")
    axes = figure.add_subplot()
    axes.hist(finite, bins="auto", color="tab:blue")
    median = f"median {np.median(finite):.4g}" if len(finite) else "no figures"
    axes.set(title=key, xlabel=f"{median}, {len(finite)} runs")
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=100)
    data = base64.b64encode(buffer.getvalue()).decode()
    return f'<img alt="{html.escape(key)}" src="data:image/png;base64,{data}">'


def _failed(outcomes: Sequence[Outcome], most: int = 10) -> str:
    failed = sorted((one for one in outcomes if not one.success), key=lambda one: -one.wall_s)
    if not failed:
        return "<p>None.</p>"
    items = [
        f'<li><a href="{html.escape(one.name)}/">{html.escape(one.name)}</a>: '
        f'<span class="bad">{html.escape(one.reason)}</span>, {one.wall_s:.0f} s</li>'
        for one in failed[:most]
    ]
    return f"<p>{len(failed)} runs.</p><ul>{''.join(items)}</ul>"


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


def compared(first: Sequence[Outcome], second: Sequence[Outcome], level: float = 0.05) -> list[str]:
    """Return lines with two campaigns' figures and how probable the difference is by chance.

    Below a level of that probability they differ.
    """
    counts = [(sum(one.success for one in each), len(each)) for each in (first, second)]
    chance = success_difference(*((good, total - good) for good, total in counts))
    lines = [_line("", ("first", "second"), "p")]
    lines.append(_line("success", [f"{a} of {b}" for a, b in counts], _verdict(chance, level)))
    keys = dict.fromkeys(key for one in (*first, *second) for key in one.figures)
    for key in keys:
        one, other = ([run.figures.get(key, np.nan) for run in each] for each in (first, second))
        medians = [f"{_median(each):.4g}" for each in (one, other)]
        lines.append(_line(key, medians, _verdict(measure_difference(one, other), level)))
    return lines


def _median(values: Sequence[float]) -> float:
    finite = np.array(values)[np.isfinite(values)]
    return float(np.median(finite)) if len(finite) else np.nan


def _verdict(chance: float, level: float) -> str:
    return f"{chance:.3f}{' differs' if chance < level else ''}"


def _line(name: str, both: Sequence[str], chance: str) -> str:
    return f"{name:28}{both[0]:>14}{both[1]:>14}  {chance}"


def wilson_interval(successes: int, count: int) -> tuple[float, float]:
    """Return the 95 % confidence interval of a probability, all of 0 to 1 of no trial.

    Wilson, "Probable inference, the law of succession, and statistical inference", JASA 22, 1927:
    right also where all or none succeed.
    """
    if count == 0:
        return 0.0, 1.0
    low, high = stats.binomtest(successes, count).proportion_ci(method="wilson")
    return float(low), float(high)


def success_difference(first: tuple[int, int], second: tuple[int, int]) -> float:
    """Return how probable so great a difference is where there is none (Fisher's exact test)."""
    return float(stats.fisher_exact([first, second]).pvalue)


def measure_difference(first: Sequence[float], second: Sequence[float]) -> float:
    """Return how probable so great a shift is where there is none (Mann-Whitney's U test)."""
    one, other = (np.array(each, float) for each in (first, second))
    one, other = one[~np.isnan(one)], other[~np.isnan(other)]
    if not len(one) or not len(other):
        return 1.0
    return float(stats.mannwhitneyu(one, other).pvalue)
