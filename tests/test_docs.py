"""Every block of code in the documentation is run or checked (see doc_pages.py), and prints what the page shows."""

import re
from collections.abc import Sequence
from pathlib import Path

import pytest
from doc_pages import ROOT, blocks, differences, examples, matches

from olp.languages.limits import writable
from olp.languages.vendor import find_vendor, part_of, vendor_names

PAGES = sorted(
    [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *ROOT.glob("docs/**/*.md"), *ROOT.glob("hosts/**/*.md")]
)
PAGES = [page for page in PAGES if "node_modules" not in page.parts]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_the_blocks_of_a_page_do_what_it_shows(page: Path, tmp_path: Path) -> None:
    wrong = differences(page.read_text(encoding="utf-8"), tmp_path)
    assert not wrong, "\n\n".join(wrong)


def test_the_first_screen_of_the_readme_holds_a_run() -> None:
    page = (ROOT / "README.md").read_text(encoding="utf-8")
    found = [example for block in blocks(page) if block.kind == "console" for example in examples(block)]
    assert any(example.line <= 40 and example.output.strip() for example in found)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_inside_the_repository_lead_somewhere(page: Path) -> None:
    links = re.findall(r"\]\(([^)\s#]+)[^)]*\)", page.read_text(encoding="utf-8"))
    local = [link for link in links if not re.match("[a-z]+:", link)]
    assert [link for link in local if not (page.parent / link).exists()] == []


# The mechanism itself: a check that finds nothing wrong proves nothing until it has found something.

PAGE = """\
```console
$ olp --version
olp …
$ olp no-such-command
…
help: olp --help lists the commands
$ echo $?
2
```
"""


def test_a_right_page_passes_and_every_wrong_line_of_a_wrong_one_is_found(tmp_path: Path) -> None:
    for number, page in enumerate((PAGE, PAGE.replace("olp …", "olp 99"), PAGE.replace("\n2\n", "\n0\n"))):
        (tmp_path / str(number)).mkdir()
        assert len(differences(page, tmp_path / str(number))) == (number > 0)


@pytest.mark.parametrize(
    ("shown", "printed", "same"),
    [
        ("a  1\nb\n", "a  1\nb\n\n", True),
        ("a  1\n", "a 1\n", False),
        ("a … c\n", "a b b c\n", True),
        ("a … c\n", "a b\nc\n", False),
        ("a\n…\nd\n", "a\nb\nc\nd\n", True),
        ("a\n…\nd\n", "a\nd\n", True),
        ("a\n…\nd\n", "a\nb\n", False),
        ("a.c\n", "abc\n", False),
        ("", "unexpected\n", False),
    ],
)
def test_output_is_compared_exactly_except_where_the_page_leaves_out(
    shown: str, printed: str, same: bool
) -> None:
    assert matches(shown, printed) is same


def _words_of(names: Sequence[str]) -> set[str]:
    """What pages call languages: their titles without the makers."""
    return {find_vendor(name).title.split()[-1] for name in names}


ONLY_READ = sorted(set(vendor_names()) - set(writable()))
COLOURED = [name for name in vendor_names() if part_of(name, "tokens") is not None]


@pytest.mark.parametrize(
    ("page", "before", "behind", "names"),
    [
        ("README.md", "It reads ", ".", vendor_names()),
        ("docs/README.md", "- languages: ", "\n", vendor_names()),
        ("docs/vendors.md", "Pages: ", "; only read: ", writable()),
        ("docs/vendors.md", "; only read: ", ".\u0020", ONLY_READ),
        ("docs/other-languages.md", "# ", "\n", ONLY_READ),
        ("hosts/emacs/README.md", ";; Robot programs: ", "\n", vendor_names()),
        ("hosts/neovim/README.md", "-- Robot programs: ", "\n", vendor_names()),
        ("hosts/vscode/README.md", "while you write it, for\n", ".\n\n", COLOURED),
    ],
)
def test_a_list_of_languages_names_those_that_are_found_and_no_other(
    page: str, before: str, behind: str, names: Sequence[str]
) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    listed = re.sub(r"\]\([^)]*\)", "]", text.partition(before)[2].partition(behind)[0])
    assert set(re.findall(r"\w+", listed)) & _words_of(vendor_names()) == _words_of(names)


@pytest.mark.parametrize("host", ["emacs", "neovim"])
def test_an_editor_opens_programs_of_every_language_with_a_suffix_of_its_own(host: str) -> None:
    page = (ROOT / "hosts" / host / "README.md").read_text(encoding="utf-8")
    words = set(re.findall(r"\w+", page.partition("Robot programs: ")[2].partition("```")[0]))
    assert [name for name in vendor_names() if not words & {s[1:] for s in find_vendor(name).suffixes}] == []


def test_robodk_has_a_post_for_every_language_that_is_written() -> None:
    host = ROOT / "hosts/robodk"
    listed = (
        (host / "README.md").read_text(encoding="utf-8").partition("Post Processor → ")[2].partition(").")[0]
    )
    posts = {f"olp_{name}" for name in writable()}
    assert set(re.findall(r"\w+", listed)) & posts == posts
    assert {path.stem for path in host.glob("Posts/olp_*.py")} == posts
