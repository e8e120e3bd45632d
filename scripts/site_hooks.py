"""Hooks of mkdocs.yml: the order of pages from docs/README.md, the reference from the code, what lies outside docs/.

Links that lead out of docs/ (a grammar, a sample, CONTRIBUTING.md) lead to copies below repository/ in the site, so
that it can be read without a network, and without knowing where the repository is kept.
"""

from __future__ import annotations

import posixpath
import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path, PurePosixPath
from typing import Any

from latex2mathml.converter import convert
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "scripts")]

from reference import reference_pages  # noqa: E402

DOCS = ROOT / "docs"
OUTSIDE = "repository"
# [text](target#anchor), not ![image]; a target with a scheme is none of ours.
LINK = re.compile(r"(?P<head>\]\()(?P<target>(?![a-z]+:)[^)#\s]+)(?P<anchor>#[^)\s]*)?(?P<tail>\))")
MATH = re.compile(r"(`[^`\n]*`)|\$(?! )([^$`\n]+)(?<! )\$")
ROW = re.compile(r"^\| (?P<what>[^|]+) \| (?P<pages>.*\]\(.*) \|$", re.M)


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """The navigation."""
    index = (DOCS / "README.md").read_text(encoding="utf-8")
    sections: list[Any] = [{"Start": "README.md"}]
    for heading, body in re.findall(r"^## ([^\n]+)\n(.*?)(?=^## |\Z)", index, re.M | re.S):
        links = [
            link
            for row in ROW.finditer(body)
            for link in re.findall(r"\[([^]]+)\]\(([^)#]+)\)", row["pages"])
        ]
        pages = [{text[:1].upper() + text[1:]: _in_site(target)} for text, target in links]
        if heading == "Reference":
            pages += [{title: path} for path, (title, _) in reference_pages().items()]
        sections.append({heading: pages})
    project = {"Contributing": "CONTRIBUTING.md", "Changes": "CHANGELOG.md"}
    sections.append({"Project": [{title: f"{OUTSIDE}/{path}"} for title, path in project.items()]})
    config.nav = sections
    return config


def _in_site(target: str) -> str:
    """Where a link of docs/README.md leads in the site."""
    return _copy_of(_outside(PurePosixPath("docs"), target) or "") if target.startswith("..") else target


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds the generated pages and the copies of what is linked outside docs/."""
    for path, (_, text) in reference_pages().items():
        files.append(File.generated(config, path, content=text))
    wanted = {"CONTRIBUTING.md", "CHANGELOG.md"}
    for page in sorted(DOCS.glob("**/*.md")):
        wanted.update(_targets(page))
    done: set[str] = set()
    while wanted - done:
        path = min(wanted - done)
        done.add(path)
        source = ROOT / path
        if source.suffix == ".md":
            files.append(
                File.generated(config, f"{OUTSIDE}/{path}", content=source.read_text(encoding="utf-8"))
            )
            wanted.update(_targets(source))
        else:
            files.append(File.generated(config, _copy_of(path), content=source.read_bytes()))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Leads links out of docs/ to the copies."""
    here = PurePosixPath(page.file.src_uri)
    inside = here.parts[0] == OUTSIDE
    folder = PurePosixPath(*here.parts[1:-1]) if inside else PurePosixPath("docs", *here.parts[:-1])

    def led(link: re.Match[str]) -> str:
        path = _outside(folder, link["target"])
        if path is None:
            target = posixpath.normpath(folder.joinpath(link["target"]).as_posix())
            to = target.removeprefix("docs/") if inside else ""
        else:
            to = _copy_of(path)
        if not to:
            return link[0]
        return f"{link['head']}{posixpath.relpath(to, here.parent.as_posix())}{link['anchor'] or ''}{link['tail']}"

    return _outside_code(markdown, lambda text: MATH.sub(_formula, LINK.sub(led, text)))


def _outside_code(markdown: str, change: Callable[[str], str]) -> str:
    """Changes all but fenced blocks."""
    parts = re.split(r"(^```.*?^```[^\n]*$)", markdown, flags=re.M | re.S)
    return "".join(part if number % 2 else change(part) for number, part in enumerate(parts))


def _formula(found: re.Match[str]) -> str:
    """A formula as MathML, which browsers draw without a script; code in a line stays."""
    return found[1] or str(convert(found[2]))


def _targets(page: Path) -> Iterator[str]:
    """What a page links to outside docs/, as paths of the repository."""
    folder = PurePosixPath(page.parent.relative_to(ROOT).as_posix())
    for link in LINK.finditer(page.read_text(encoding="utf-8")):
        path = _outside(folder, link["target"])
        if path is not None:
            yield path


def _outside(folder: PurePosixPath, target: str) -> str | None:
    """The path of the repository that a link leads to if that is outside docs/; a folder stands for its README."""
    path = posixpath.normpath(folder.joinpath(target).as_posix())
    if path.startswith(("docs/", "..")) or path == "docs":
        return None
    whole = ROOT / path
    if whole.is_dir():
        return f"{path}/README.md" if (whole / "README.md").exists() else None
    return path if whole.exists() else None


def _copy_of(path: str) -> str:
    """Where a file of the repository is in the site: pages as pages, all else as text that a browser shows."""
    shown = path.endswith((".md", ".html", ".png", ".svg"))
    return f"{OUTSIDE}/{path}" if shown else f"{OUTSIDE}/{path}.txt"
