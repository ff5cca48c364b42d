"""The site needs no other site: MathJax is copied into it, and a build that loads anything fails.

MathJax comes from the package django-static-mathjax of the extra `docs`, which holds it whole and
needs no Django.  Links that a reader follows may lead anywhere; what a page loads by itself, such
as scripts, style sheets, fonts and pictures, must be in the site.
"""

import re
from importlib.util import find_spec
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files

MATHJAX = ("tex-mml-chtml.js", "output/chtml/fonts/woff-v2/*", "input/tex/extensions/*.js")
"""What pages load of MathJax: itself, its fonts, and the packages for rare commands of TeX."""
LOADED = re.compile(
    r"""<(?:script|img|iframe|source|embed)\b[^>]*?\ssrc=["']?((?:https?:)?//[^"'\s>]+)"""
    r"""|<link\b(?=[^>]*rel=["']?(?:stylesheet|preconnect|preload|icon|modulepreload))[^>]*?"""
    r"""\shref=["']?((?:https?:)?//[^"'\s>]+)"""
    r"""|(?:url\(|@import\s+)["']?((?:https?:)?//[^"')\s]+)""",
    re.IGNORECASE,
)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add MathJax to the files of the site."""
    package = find_spec("mathjax")
    if package is None or package.origin is None:
        raise PluginError("the site needs MathJax; run pip install '.[docs]'.")
    folder = Path(package.origin).parent / "static" / "mathjax" / "es5"
    for pattern in MATHJAX:
        for path in sorted(folder.glob(pattern)):
            place = f"mathjax/{path.relative_to(folder).as_posix()}"
            files.append(File.generated(config, place, abs_src_path=str(path)))
    return files


def on_post_build(config: MkDocsConfig) -> None:
    """Raise PluginError if a page or style sheet of the site loads something from elsewhere."""
    site = Path(config.site_dir)
    foreign = {
        f"{path.relative_to(site)} loads {address}"
        for kind in ("html", "css")
        for path in site.rglob(f"*.{kind}")
        for address in loaded_from_elsewhere(path.read_text(encoding="utf-8"))
    }
    if foreign:
        raise PluginError("the site would not work offline: " + "; ".join(sorted(foreign)[:5]))


def loaded_from_elsewhere(text: str) -> list[str]:
    """Return the addresses on other sites that a page or style sheet loads by itself."""
    return ["".join(groups) for groups in LOADED.findall(text)]
