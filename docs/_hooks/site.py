"""Pages of the site that stand elsewhere in the repository, and the API page.

A page links to a file outside of docs/ by its path in the repository (`../CHANGELOG.md`), so that
the link also works where the repository is browsed. In the site such a link leads to the copy of
that file, or becomes plain text if the site has no copy. A picture with a twin for dark pages
becomes both, of which the theme shows one.
"""

from __future__ import annotations

import ast
import re
from pathlib import Path

from build_cache import ROOT
from generate import keys_of
from mkdocs.structure.files import File
from picture_parts import dark_twin

PAGES = {
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
    "acoustics/CONFORMANCE.md": "conformance.md",
}
PICTURES = "scenarios/pictures/"
PACKAGES = ("rolling", "acoustics")
LINK = re.compile(r"(!?)\[([^\]]*)\]\((?:\.\./)+([^)#\s]+)(#[^)\s]*)?\)")
# A type with its unit or default, such as `float, N`, which mkdocstrings takes for a tuple.
TYPE = re.compile(r'<code>\((.*)\)</code>(?=\s*</td>\s*<td>\s*<div class="doc-md-description">)')
OWN_LINK = re.compile(r"\]\(docs/([^)\s]+)\)")


def on_files(files, config):
    """Add the pages and pictures that stand outside of docs/, and the API page."""
    for source, target in PAGES.items():
        text = (ROOT / source).read_text(encoding="utf-8")
        for page, copy in PAGES.items():
            text = text.replace(f"]({page})", f"]({copy})")
        files.append(File.generated(config, target, content=OWN_LINK.sub(r"](\1)", text)))
    for picture in sorted((ROOT / PICTURES).glob("*.[ps][nv]g")):
        files.append(File.generated(config, f"pictures/{picture.name}", abs_src_path=str(picture)))
    files.append(File.generated(config, "api.md", content=api_page()))
    return files


def on_page_markdown(markdown, page, config, files):
    """Turn links to files of the repository into links within the site."""
    return LINK.sub(_within_site, markdown.replace(".ipynb)", ".md)"))


def on_page_content(content, page, config, files):
    """Write types with their units as docstrings do."""
    if page.file.src_uri != "api.md":
        return content
    return TYPE.sub(lambda type_: f"<code>{type_[1].replace(' / ', '/')}</code>", content)


def _within_site(match):
    picture, text, path, anchor = match.groups()
    if path.startswith(PICTURES):
        shown = f"{picture}[{text}](pictures/{Path(path).name}"
        twin = dark_twin(ROOT / path)
        if picture and twin.exists():
            return f"{shown}#only-light){picture}[{text}](pictures/{twin.name}#only-dark)"
        return f"{shown})"
    if path in PAGES:
        return f"[{text}]({PAGES[path]}{anchor or ''})"
    return match[0] if (ROOT / "docs" / path).is_file() else text  # of a page in a folder


def exported_names(package):
    """List the names that a package exports, in the order of their modules.

    Public names are imported lazily at run time; for editors the same imports stand in a stub, or
    under `TYPE_CHECKING`.
    """
    sources = (ROOT / package / f"__init__.{ending}" for ending in ("pyi", "py"))
    source = next(path for path in sources if path.exists())
    return [
        alias.name
        for node in ast.walk(ast.parse(source.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == package
        for alias in node.names
    ]


def api_page():
    """Return the Markdown of the API page: every exported name under the name one imports."""
    lines = [
        "# API",
        "",
        "**Which functions and classes may I import?** All on this page. Arguments and results "
        "are in SI units unless a name carries its unit.",
        "",
    ]
    for package in PACKAGES:
        lines += [f"## {package}", ""]
        for name in exported_names(package):
            lines.append(f"::: {package}.{name}\n")
            if keys := keys_of(name):  # its own and those of its bases
                lines += ["    options: {show_docstring_attributes: false}\n", keys, ""]
    return "\n".join(lines)
