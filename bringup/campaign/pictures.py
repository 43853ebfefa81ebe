"""Pictures of a campaign: the share of successes, and a box plot or histogram of each figure."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bringup.campaign.comparison import figures, wilson_interval
from bringup.campaign.outcome import Outcome
from bringup.campaign.plan import UNFIT, Campaign

mpl.use("Agg")
Groups = dict[str, Sequence[Outcome]]
"""Outcomes by name: those of all, then those of each level of each condition."""
_COLOURS = ("tab:blue", "tab:orange", "tab:green", "tab:purple", "tab:brown", "tab:cyan")


def pictures_of(
    campaign: Campaign, groups: Groups, measures: Sequence[str]
) -> Iterator[tuple[str, bytes, bytes]]:
    """Yield each picture's name and its bytes as PNG and as PDF, which depend on nothing else."""
    alone = len(groups) == 1 and not campaign.compare
    for name in dict.fromkeys([*([] if alone else ["success"]), *measures]):
        width = 4.0 if alone else max(9.0, len(groups))
        figure = Figure(figsize=(width, 3.0), layout="constrained")
        axes = figure.add_subplot()
        if alone:
            _draw_histogram(axes, name, figures(next(iter(groups.values())), name))
        else:
            _draw_groups(axes, campaign, groups, name)
        yield (UNFIT.sub("-", name), *_saved(figure))


def _saved(figure: Figure) -> tuple[bytes, bytes]:
    """Return a figure as PNG and as PDF, without dates, its letters as outlines that print."""
    png, pdf = io.BytesIO(), io.BytesIO()
    with mpl.rc_context({"pdf.fonttype": 42}):
        figure.savefig(png, format="png", dpi=100, metadata={"Software": "arjuna"})
        figure.savefig(pdf, format="pdf", metadata={"CreationDate": None})
    return png.getvalue(), pdf.getvalue()


def _draw_histogram(axes: Axes, key: str, values: Sequence[float]) -> None:
    finite = np.array([value for value in values if np.isfinite(value)])
    axes.hist(finite, bins="auto", color=_COLOURS[0])
    median = f"median {np.median(finite):.4g}" if len(finite) else "no figures"
    axes.set(title=key, xlabel=f"{median}, {len(finite)} runs")


def _draw_groups(axes: Axes, campaign: Campaign, groups: Groups, key: str) -> None:
    """Draw a figure, or the share of successes, beside each other by group and what is compared."""
    factor = campaign.compare
    levels = [level.label for level in campaign.factors[factor]] if factor else [""]
    width = 0.8 / len(levels)
    for number, level in enumerate(levels):
        colour = _COLOURS[number % len(_COLOURS)]
        axes.plot([], [], "s", color=colour, label=level)
        for position, outcomes in enumerate(groups.values()):
            chosen = [one for one in outcomes if not factor or one.levels[factor] == level]
            x = position + (number + 0.5) * width - 0.4
            if key == "success":
                _draw_share(axes, x, chosen, colour)
            else:
                _draw_box(axes, x, 0.8 * width, chosen, key, colour)
    axes.set_xticks(range(len(groups)), list(groups))
    axes.set_xlim(-0.5, len(groups) - 0.5)
    axes.set(title=key, xlabel="" if len(campaign.conditions) > 1 else "".join(campaign.conditions))
    axes.axvline(0.5, color="grey", lw=0.8)
    axes.grid(axis="y", alpha=0.3)
    if factor:
        axes.legend(title=factor, loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)


def _draw_share(axes: Axes, x: float, outcomes: Sequence[Outcome], colour: str) -> None:
    if not outcomes:
        return
    good = sum(one.success for one in outcomes)
    share = good / len(outcomes)
    low, high = wilson_interval(good, len(outcomes))
    reach = [[max(share - low, 0.0)], [max(high - share, 0.0)]]
    axes.errorbar([x], [share], yerr=reach, fmt="o", color=colour, capsize=4)
    axes.set_ylim(-0.02, 1.05)


def _draw_box(
    axes: Axes,
    x: float,
    width: float,
    outcomes: Sequence[Outcome],
    key: str,
    colour: str,
    dots: int = 30,
) -> None:
    """Draw a box, and each run as a dot where they are few."""
    shown = [one for one in outcomes if np.isfinite(one.figures.get(key, np.nan))]
    values = np.array(figures(shown, key))
    if not len(shown):
        return
    few = len(shown) <= dots
    axes.boxplot(
        [values],
        positions=[x],
        widths=width,
        manage_ticks=False,
        showfliers=not few,
        patch_artist=True,
        boxprops={"facecolor": colour, "alpha": 0.35, "edgecolor": colour},
        medianprops={"color": "black"},
        whiskerprops={"color": colour},
        capprops={"color": colour},
        flierprops={"marker": ".", "ms": 3, "markeredgecolor": colour},
    )
    if few:
        beside = x + width * (np.arange(len(shown)) % 5 - 2.0) / 6.0
        shades = [colour if one.success else "tab:red" for one in shown]
        axes.scatter(beside, values, c=shades, s=9, zorder=3)
