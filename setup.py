"""The parts of the build that pyproject.toml cannot say.

The folder scenarios/ becomes the data package `rolling.scenarios`, so that an installed program has
its scenes. The README becomes the text of an index page, where relative links would lead nowhere.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from setuptools import find_packages, setup

ROOT = Path(__file__).parent
SCENES = "rolling.scenarios"
LINK = re.compile(r"(!?)\[([^\]]*)\]\((?!#|[a-z][a-z0-9+.-]*:)([^)\s]+)\)")
PICTURE = re.compile(r'<picture>.*?<img alt="([^"]*)" src="([^"]*)"></picture>')
LAST_LINE = "The linked files are in the source distribution."


def index_page(readme: str, repository: str | None, revision: str) -> str:
    """Return the README with links that work on an index page.

    Parameters
    ----------
    readme : str. Markdown with links relative to the repository.
    repository : str or None. Address of the repository. Links to files of the repository become
        absolute. None: pictures are left out, links become text, and a last line says where the
        files are.
    revision : str. Tag or branch that the links lead to.
    """

    def absolute(match: re.Match[str]) -> str:
        picture, text, path = match.groups()
        if repository is None:
            return "" if picture else text
        kind = "raw" if picture else "tree" if path.endswith("/") else "blob"
        return f"{picture}[{text}]({repository.rstrip('/')}/{kind}/{revision}/{path})"

    of_light_pages = PICTURE.sub(r"![\1](\2)", readme)  # an index page has no dark form
    page, changed = LINK.subn(absolute, of_light_pages)
    if repository is None and changed:
        page = re.sub(r"\n{3,}", "\n\n", page).rstrip() + f"\n\n{LAST_LINE}\n"
    return page


TABLES = (
    "studies",
    "results",
    "scene",
    "surface",
)  # rooms with tables beside their code


def project_page() -> str:
    """Return the text of the index page of this version."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    revision = "HEAD" if ".dev" in project["version"] else f"v{project['version']}"
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    return index_page(readme, project.get("urls", {}).get("Repository"), revision)


if __name__ == "__main__":
    setup(
        packages=[*find_packages(include=["rolling*", "acoustics*"]), SCENES],
        package_dir={SCENES: "scenarios"},
        package_data={
            "rolling": ["py.typed", "*.pyi"],
            **{f"rolling.{room}": ["*.toml", "*.yaml"] for room in TABLES},
            "acoustics": ["py.typed", "*.pyi"],
            "rolling.report": ["assets/*", "assets/*/*.js"],
            SCENES: ["*.yaml", "*.sdf", "*.schema.json", "*/*/*.yaml", "validation/*"],
        },
        include_package_data=False,
        long_description=project_page(),
        long_description_content_type="text/markdown",
    )
