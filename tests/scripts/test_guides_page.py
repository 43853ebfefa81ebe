"""docs/guides.md is current, and every test that it names is there."""

from __future__ import annotations

from pathlib import Path

import pytest

from scripts.guides_page import ORDER, PAGE, ROOT, page, read, table_of

ROWS = [row for guide in ORDER for rows in read(table_of(guide))[1].values() for row in rows]


def test_the_page_is_current() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "run: python -m scripts.guides_page"


def test_every_guide_has_its_tables() -> None:
    assert {path.parent.name for path in (ROOT / "guides").glob("*/params.yaml")} == set(ORDER)
    assert len(ROWS) > 250
    assert all(row.theirs and row.here and row.test for row in ROWS)


@pytest.mark.parametrize("test", sorted({row.test for row in ROWS}))
def test_a_named_test_is_there(test: str) -> None:
    file, _, name = test.partition("::")
    assert f"def {name or 'test_'}" in (ROOT / file).read_text(encoding="utf-8")


def test_a_line_that_is_no_row_is_named(tmp_path: Path) -> None:
    path = tmp_path / "table.txt"
    path.write_text("# A\n\n## B\n\nx | y\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"table\.txt:5: expected 'theirs \| here"):
        read(path)
