"""README with absolute links, and the addresses of the project, for package indexes.

The address of the repository is that of the forge that builds (GITHUB_SERVER_URL and
GITHUB_REPOSITORY, which its workflows set).  Elsewhere none is known: pictures are left out, and
links into the repository become plain words.
"""

import os
import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

LINK = re.compile(r"(!?)\[([^\]]*)\]\((?!https?:|#)([^)]+)\)")


def repository() -> str:
    """Return the address of the repository; "" if none is known."""
    server, name = (os.environ.get(f"GITHUB_{part}", "") for part in ("SERVER_URL", "REPOSITORY"))
    return f"{server}/{name}" if server and name else ""


def index_readme(text: str, url: str) -> str:
    """Return README as an index shows it, which has no files for relative links."""

    def absolute(link: re.Match[str]) -> str:
        picture, words, path = link.groups()
        if not url:
            return "" if picture else words
        return f"{picture}[{words}]({url}/{'raw' if picture else 'blob'}/main/{path})"

    return LINK.sub(absolute, text)


def project_urls(url: str) -> dict[str, str]:
    """Return the addresses of the project by name; none without a repository."""
    places = {
        "Repository": "",
        "Documentation": "/blob/main/docs/start.md",
        "Changelog": "/blob/main/CHANGELOG.md",
        "Issues": "/issues",
    }
    return {name: url + place for name, place in places.items()} if url else {}


class CustomMetadataHook(MetadataHookInterface):
    """Fills the fields `readme` and `urls` of the project."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Fill them, in place."""
        text = (Path(self.root) / "README.md").read_text(encoding="utf-8")
        shown = index_readme(text, repository())
        metadata["readme"] = {"content-type": "text/markdown", "text": shown}
        metadata["urls"] = project_urls(repository())
