"""docs/cells.md shows what the writers write today."""

from bench.cells_page import CELLS, PAGE, page
from olp.languages.limits import writable
from olp.languages.vendor import vendor_names


def test_the_page_shows_what_the_writers_write() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "python bench/cells_page.py writes it again"


def test_each_language_stands_there_before_and_each_that_is_written_after() -> None:
    assert {cell.source.partition("/")[0] for cell in CELLS} == set(vendor_names())
    assert {cell.target for cell in CELLS} == set(writable())
