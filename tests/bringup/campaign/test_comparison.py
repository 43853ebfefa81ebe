"""Results: judged, compared and as tables."""

from __future__ import annotations

import itertools
import math
import re
from statistics import NormalDist
from typing import Any

import numpy as np
import pytest

from arjuna_core.config import dotted
from bringup.campaign.comparison import (
    Estimate,
    compared,
    discordant,
    estimate,
    measure_difference,
    paired_difference,
    success_difference,
    wilson_interval,
)
from bringup.campaign.outcome import Outcome, figures_of, judged
from bringup.campaign.report import Table


def outcome(name: str, success: bool, **figures: float) -> Outcome:
    return Outcome(name, {}, success, "", 1.0, figures)


@pytest.mark.parametrize(
    ("successes", "count", "interval"),
    [(0, 0, (0.0, 1.0)), (0, 20, (0.0, 0.1611)), (81, 263, (0.2553, 0.3662)),
     (20, 20, (0.8389, 1.0))],
)  # fmt: skip
def test_wilson_s_interval(successes: int, count: int, interval: tuple[float, float]) -> None:
    assert wilson_interval(successes, count) == pytest.approx(interval, abs=1e-4)


def test_wilson_s_interval_holds_the_truth_as_often_as_it_says() -> None:
    drawn = np.random.default_rng(0).binomial(50, 0.9, 2000)
    intervals = [wilson_interval(n, 50) for n in range(51)]
    held = [intervals[n][0] <= 0.9 <= intervals[n][1] for n in drawn]
    assert np.mean(held) == pytest.approx(0.95, abs=0.03)


def test_the_lady_tasting_tea() -> None:
    assert success_difference((3, 1), (1, 3)) == pytest.approx(0.4857, abs=1e-4)


def test_a_shift_is_distinguished_from_none() -> None:
    rng = np.random.default_rng(1)
    one, same, other = rng.normal(0, 1, 50), rng.normal(0, 1, 50), rng.normal(1, 1, 50)
    assert measure_difference(list(one), list(other)) < 0.01
    assert measure_difference(list(one), list(same)) > 0.05
    assert measure_difference(list(one), [np.nan]) == 1.0


def exact_bca(data: list[float]) -> tuple[float, float]:
    """Return Efron's interval of the mean of all resamples there are (1987, equations 2.3, 6.6)."""
    means = np.sort([np.mean(one) for one in itertools.product(data, repeat=len(data))])
    below = np.mean(means < np.mean(data)) + 0.5 * np.mean(np.isclose(means, np.mean(data)))
    left_out = np.array([np.mean(data[:k] + data[k + 1 :]) for k in range(len(data))])
    d = left_out.mean() - left_out
    normal = NormalDist()
    z0, a = normal.inv_cdf(below), (d**3).sum() / (6.0 * (d**2).sum() ** 1.5)
    ends = [z0 + (z0 + z) / (1.0 - a * (z0 + z)) for z in map(normal.inv_cdf, (0.025, 0.975))]
    low, high = np.quantile(means, [normal.cdf(end) for end in ends])
    return float(low), float(high)


def test_the_interval_of_a_mean_is_that_of_all_resamples() -> None:
    data = [1.0, 2.0, 2.5, 4.0, 9.0, 20.0]  # skew: the plain percentiles are 2.4 and 12.0
    found = estimate(data)
    assert found.count == 6
    assert found.mean == pytest.approx(6.4167, abs=1e-4)
    assert (found.low, found.high) == pytest.approx(exact_bca(data), abs=0.2)
    assert found == estimate(data) != estimate(data, seed=1)


def test_the_interval_holds_the_mean_as_often_as_it_says() -> None:
    drawn = np.random.default_rng(0).exponential(2.0, (300, 30))
    held = [one.low <= 2.0 <= one.high for one in (estimate(row, resamples=999) for row in drawn)]
    assert np.mean(held) == pytest.approx(0.93, abs=0.03)  # of skew data rather less than 0.95


def test_few_or_equal_values_have_no_interval_and_many_have_one() -> None:
    assert not math.isfinite(estimate([1.0, 2.0, 3.0, 4.0, 5.0]).low)
    assert not estimate([3.0, 3.1, 3.2]).significant
    assert (str(estimate([])), str(estimate([0.25, 0.35]))) == ("", "0.3")
    assert str(estimate([2.0] * 9)) == "2"
    many = estimate(np.random.default_rng(0).normal(5.0, 1.0, 2000))
    assert (many.low, many.high) == pytest.approx((5.0 - 0.044, 5.0 + 0.044), abs=0.06)
    assert many.high - many.low == pytest.approx(2 * 1.96 / math.sqrt(2000), rel=0.1)
    assert estimate([1.0, math.nan, math.inf, 3.0]).mean == 2.0


def test_an_estimate_is_written_with_the_digits_that_its_interval_gives_sense_to() -> None:
    assert str(Estimate(9, 0.32634, 0.29511, 0.34587)) == "0.326 [0.295, 0.346]"
    assert str(Estimate(9, 1234.5, 1100.0, 1300.0)) == "1234 [1100, 1300]"
    assert str(Estimate(9, -0.0001, -0.05, 0.05)) == "0.000 [-0.050, 0.050]"


def test_pairs_distinguish_what_the_runs_themselves_hide() -> None:
    rng = np.random.default_rng(2)
    seeds = rng.normal(10.0, 5.0, 20)
    first = [outcome(f"{k}", True, time=time) for k, time in enumerate(seeds)]
    second = [
        outcome(f"{k}", True, time=time + shift)
        for (k, time), shift in zip(enumerate(seeds), rng.normal(0.5, 0.1, 20), strict=True)
    ]
    found = paired_difference(list(zip(first, second, strict=True)), "time")
    assert found.significant
    assert found.count == 20
    assert found.mean == pytest.approx(0.5, abs=0.05)
    line = compared(first, second[::-1])[-1]
    assert "differs" not in line
    assert line.endswith(str(found))
    assert not compared(first, [outcome("other", True, time=1.0)])[0].endswith("pairs")


def test_unequal_successes_of_pairs_have_mcnemar_s_probability() -> None:
    good, bad = outcome("a", True), outcome("a", False)
    pairs = [(good, good)] * 30 + [(good, bad)] * 1 + [(bad, good)] * 5 + [(bad, bad)]
    first, second, chance = discordant(pairs)
    assert (first, second) == (1, 5)
    assert chance == pytest.approx(2 * (1 + 6) / 2**6)
    assert discordant([(good, good)])[2] == 1.0


@pytest.mark.parametrize(
    ("result", "success", "lacks"),
    [
        ({"ok": True}, {"ok": True}, ""),
        ({"ok": False}, {"ok": True}, "ok False, not True"),
        ({"ok": True}, {"ok": False}, "ok True, not False"),
        ({"end": "home"}, {"end": "home"}, ""),
        ({}, {"end": "home"}, "end None, not home"),
        ({"n": 3}, {"n": {"at_least": 3, "at_most": 3}}, ""),
        ({"n": 2}, {"n": {"at_least": 3}}, "n 2, not at least 3"),
        ({"n": 4}, {"n": {"at_most": 3}}, "n 4, not at most 3"),
        ({"n": "many"}, {"n": {"at_least": 3}}, "n many, not at least 3"),
        ({"a": 1, "b": 1}, {"a": 2, "b": 2}, "a 1, not 2; b 1, not 2"),
    ],
)
def test_a_result_is_judged_key_by_key(
    result: dict[str, Any], success: dict[str, Any], lacks: str
) -> None:
    assert judged(result, success) == lacks


def test_numbers_and_truths_of_a_result_are_its_figures() -> None:
    flat = dotted({"a": {"b": 1, "c": {"d": True}}, "e": [1], "f": "text"})
    assert figures_of(flat) == {"a.b": 1.0, "a.c.d": 1.0}


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
