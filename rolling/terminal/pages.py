"""Pages that a command writes: the place that is refused, and the browser that opens one."""

import sys
import webbrowser
from pathlib import Path

from rolling.terminal.whole_files import FolderError


def open_page(page: Path) -> None:
    """Open a page in a browser, or say why it is not open."""
    if not page.is_file():
        print("--open: there is no report page to open", file=sys.stderr)
    elif not webbrowser.open(page.resolve().as_uri()):
        print(f"--open: no browser was found; open {page} in one", file=sys.stderr)


def refuse_page(out: Path) -> None:
    """Refuse a page that exists, or whose ending no browser opens.

    Raises
    ------
    FolderError : the page cannot be written there.
    """
    if out.exists():
        raise FolderError(f"{out}: exists; take another --out, or remove it")
    if out.suffix.lower() not in (".html", ".htm"):
        raise FolderError(f"{out}: a page ends in .html, such as --out {out.name}.html")
