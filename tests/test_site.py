"""The documentation as a site, built as `scripts/docs` does, without a network."""

from __future__ import annotations

import os
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

from olp import cli
from olp.robots.robot import robot_names
from olp.timing.physics import term_names

ROOT = Path(__file__).parent.parent


class Anchors(HTMLParser):
    """What a page names, what it links to, and what a browser loads with it."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.ids: set[str] = set()
        self.links: list[str] = []
        self.loads: list[str] = []
        self.feed(page.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = {name: value or "" for name, value in attrs}
        self.ids.update(values[name] for name in ("id", "name") if name in values)
        if tag == "a" and "href" in values:
            self.links.append(values["href"])
        if "src" in values:
            self.loads.append(values["src"])
        if tag == "link" and values.get("rel") not in ("canonical", "next", "prev"):
            self.loads.append(values["href"])


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)],
        cwd=ROOT,
        env={**os.environ, "NO_MKDOCS_2_WARNING": "1", "https_proxy": "http://127.0.0.1:9"},
        capture_output=True,
        encoding="utf-8",
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[Path, Anchors]:
    return {page: Anchors(page) for page in sorted(site.glob("**/*.html"))}


def test_every_link_and_every_anchor_leads_somewhere(site: Path, pages: dict[Path, Anchors]) -> None:
    dead = []
    for page, found in pages.items():
        for link in found.links:
            parts = urlsplit(link)
            if parts.scheme or page.name == "404.html":
                continue
            target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
            target = target / "index.html" if target.is_dir() else target
            if not target.exists() or (
                parts.fragment
                and target.suffix == ".html"
                and unquote(parts.fragment) not in pages[target].ids
            ):
                dead.append(f"{page.relative_to(site)}: {link}")
    assert dead == []


def test_nothing_is_loaded_from_elsewhere(pages: dict[Path, Anchors]) -> None:
    assert [
        load for found in pages.values() for load in found.loads if urlsplit(load).scheme not in ("", "data")
    ] == []


def test_the_reference_tells_of_everything_there_is(pages: dict[Path, Anchors], site: Path) -> None:
    reference = site / "reference"
    told = {f"olp-{name.replace(' ', '-')}" for name in cli.names()}
    assert told <= pages[reference / "commands.html"].ids
    members = (reference / "members.html").read_text(encoding="utf-8")
    assert [name for name in term_names() if f"<code>{name}</code>" not in members] == []
    robots = (reference / "robots.html").read_text(encoding="utf-8")
    assert [name for name in robot_names() if f"<code>{name}</code>" not in robots] == []
    assert {"olp.fluent.read", "olp.fluent.FluentPlan.time"} <= pages[reference / "python.html"].ids


def test_every_page_is_in_the_index() -> None:
    index = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
    written = {page.relative_to(ROOT / "docs").as_posix() for page in ROOT.glob("docs/**/*.md")} - {
        "README.md"
    }
    assert [page for page in sorted(written) if f"({page})" not in index] == []
