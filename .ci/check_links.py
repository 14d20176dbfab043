#!/usr/bin/env python3
"""Check every link of the built docs and of the README: the page, the picture and the place in it must be there.

Links to other hosts are listed with --others, not followed: CI has no network but package indexes.
"""

from __future__ import annotations

import re
import sys
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

README_LINK = re.compile(r"\]\(([^)\s]+)\)")


class Page(HTMLParser):
    """What one page links to, and the places that others may link to."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.places: set[str] = set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in ("href", "src") and value and tag != "link":
                self.links.append(value)
            if name in ("id", "name") and value:
                self.places.add(value)


read_page = cache(Page)


def broken(page: Path, link: str) -> str | None:
    """Why a link leads nowhere, or None."""
    parts = urlsplit(link)
    target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
    if target.is_dir():
        target = target / "index.html"
    if not target.is_file():
        return f"{page}: {link}: no such file"
    if parts.fragment and target.suffix == ".html" and unquote(parts.fragment) not in read_page(target).places:
        return f"{page}: {link}: no such place"
    return None


def main() -> int:
    built = Path(sys.argv[1]).resolve()
    links = [
        (page, link)
        for page in sorted(built.rglob("*.html"))
        if "_static" not in page.parts
        for link in read_page(page).links
    ]
    for text in (Path("README.md"), Path("CONTRIBUTING.md")):
        links += [(text.resolve(), link) for link in README_LINK.findall(text.read_text(encoding="utf-8"))]
    inside = [(page, link) for page, link in links if not urlsplit(link).scheme and not link.startswith("//")]
    faults = sorted({fault for page, link in inside if (fault := broken(page, link))})
    if "--others" in sys.argv:
        print("\n".join(sorted({link for _, link in links if urlsplit(link).scheme in ("http", "https")})))
    print("\n".join([*faults, f"{len(inside)} links checked, {len(faults)} broken"]))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
