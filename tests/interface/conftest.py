"""Fixtures of the tests of the page: a browser, and pages in it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from report_browser import FLAGS, PATIENCE, TAP, browser_path, without_browser
from report_runs import runs_of

from rolling.report.report_page import page


@pytest.fixture(scope="session")
def browser() -> Iterator:
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        without_browser("no playwright")
    path = browser_path()
    if path is None:
        without_browser("no browser")
    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=path, args=FLAGS)
        yield opened
        opened.close()


@pytest.fixture(scope="session")
def pages(tmp_path_factory: pytest.TempPathFactory):
    """Return the page of runs by their names, made once."""
    folder = tmp_path_factory.mktemp("pages")

    def page_of(*names: str) -> Path:
        out = folder / f"{'+'.join(names)}.html"
        if not out.exists():
            out.write_bytes(page(runs_of(*names)))
        return out

    return page_of


@pytest.fixture
def opened(browser):
    """Open a page, and fail if it complains or asks for any other file or address."""

    @contextmanager
    def open_page(path: Path, **settings):
        context = browser.new_context(**{"viewport": {"width": 1280, "height": 900}, **settings})
        context.set_default_timeout(1000 * PATIENCE)
        page = context.new_page()
        complaints: list[str] = []
        page.on("console", lambda message: complaints.append(f"{message.type}: {message.text}"))
        page.on("pageerror", lambda error: complaints.append(str(error)))

        def dismiss(dialog):
            complaints.append(f"dialog: {dialog.message}")
            dialog.dismiss()

        def watch(route):
            if route.request.url.startswith((path.as_uri(), "data:", "blob:")):
                route.continue_()
            else:
                complaints.append(f"asked for {route.request.url}")
                route.abort()

        page.on("dialog", dismiss)
        page.route("**/*", watch)
        page.add_init_script(TAP)
        page.goto(path.as_uri())
        yield page
        assert complaints == []
        context.close()

    return open_page
