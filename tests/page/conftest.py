"""A browser and the report that it opens. Without either the tests are skipped, unless REQUIRE_BROWSER=1."""

import os
import shutil
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROGRAMS = ("chromium", "chromium-browser", "google-chrome")
PATIENCE = 600_000
"""Milliseconds after which a test gives up; no outcome depends on it."""
FOLDER = Path(os.environ.get("REPORT", ROOT / "reports"))


def missing():
    """What these tests lack, in one line; empty if nothing."""
    if "REPORT" not in os.environ:
        return "no report is named to a browser: `make page` opens the last one"
    try:
        import axe_playwright_python  # noqa: F401
        import playwright  # noqa: F401
    except ImportError:
        return "no browser is driven here: `make page` installs what drives it"
    if not (FOLDER / "index.html").exists():
        return f"there is no report in {FOLDER}: `make report` writes one"
    return ""


@pytest.fixture(scope="session")
def browser():
    """Chromium: that of the system, or playwright's own."""
    if lack := missing():
        if os.environ.get("REQUIRE_BROWSER") == "1":
            pytest.fail(lack)
        pytest.skip(lack)
    from playwright.sync_api import Error, sync_playwright

    program = next(filter(None, map(shutil.which, PROGRAMS)), None)
    with sync_playwright() as driver:
        try:
            browser = driver.chromium.launch(executable_path=program, args=["--no-sandbox"], timeout=PATIENCE)
        except Error as error:
            if os.environ.get("REQUIRE_BROWSER") == "1":
                raise
            pytest.skip(f"no browser starts: {str(error).splitlines()[0]}")
        yield browser
        browser.close()


@pytest.fixture
def opened(browser):
    """Opens the report in a window; complaints of the browser and addresses that it asked for are kept."""
    contexts = []

    def window(width=1280, height=800, script=True, scheme="light", at=""):
        context = browser.new_context(
            viewport={"width": width, "height": height}, java_script_enabled=script, color_scheme=scheme
        )
        context.set_default_timeout(PATIENCE)
        contexts.append(context)
        page = context.new_page()
        page.complaints, page.asked = [], []
        page.on("pageerror", lambda error: page.complaints.append(str(error)))
        page.on("console", lambda said: page.complaints.append(said.text) if said.type == "error" else None)
        page.on("request", lambda request: page.asked.append(request.url))
        page.goto((FOLDER / "index.html").resolve().as_uri() + at)
        return page

    yield window
    for context in contexts:
        context.close()
