"""Links of the lessons to pages and to one another, right in Jupyter and in the site.

MkDocs follows links to files in its own pages only; a notebook arrives as finished HTML.
"""

import re
from posixpath import dirname, join, normpath

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.plugins import get_plugin_logger
from mkdocs.structure.files import Files
from mkdocs.structure.pages import Page

LINK = re.compile(r'href="(?!\w+:)([^"#]+\.(?:md|ipynb))(#[^"]*)?"')
log = get_plugin_logger("notebook links")


def on_page_content(html: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """HTML of a notebook with links to places in the site, but for that to the notebook itself.

    That one is to download it: the file lies beside its page.
    """
    here = page.file.src_uri
    if not here.endswith(".ipynb"):
        return html

    def in_the_site(link: re.Match[str]) -> str:
        target = normpath(join(dirname(here), link[1]))
        if target == here:
            return f'href="{link[1]}" download'
        file = files.get_file_from_path(target)
        if file is None:
            log.warning(f"{here}: there is no {link[1]}")  # which ends a strict build
            return link[0]
        return f'href="{file.url_relative_to(page.file)}{link[2] or ""}"'

    return LINK.sub(in_the_site, html)
