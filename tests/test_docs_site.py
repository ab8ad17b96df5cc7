"""The documentation's site lists every page, and every link from page to page leads somewhere."""

import re
from pathlib import Path

import pytest

import slipwave

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = sorted(path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.md"))


def test_every_page_is_in_the_navigation_once():
    navigation = (ROOT / "mkdocs.yml").read_text().split("nav:\n")[1].split("\n\n")[0]
    assert sorted(re.findall(r": (\S+\.md)$", navigation, re.M)) == PAGES


@pytest.mark.parametrize("page", [*(f"docs/{page}" for page in PAGES), "README.md", "CONTRIBUTING.md"])
def test_links_lead_to_files(page):
    text = re.sub(r"```.*?```", "", (ROOT / page).read_text(encoding="utf-8"), flags=re.S)
    links = [link for link in re.findall(r"\]\(([^)\s#]+\.\w+)", text) if "://" not in link]
    assert [link for link in links if not ((ROOT / page).parent / link).exists()] == []


def test_the_page_of_slipwave_has_every_function_that_it_offers():
    """By the place where each is written; names that begin with _ are left out of all pages."""
    page = (DOCS / "code" / "slipwave.md").read_text()
    functions = [getattr(slipwave, name) for name in slipwave.__all__ if name not in ("NumericsError", "SceneError", "read")]
    assert [one.__name__ for one in functions if f"::: {one.__module__}.{one.__name__}\n" not in page] == []
    assert 'filters: ["!^_"]' in (ROOT / "mkdocs.yml").read_text()


@pytest.mark.parametrize("room", ["slipwave", "reduced", "fullwave", "validation"])
def test_every_room_has_a_page_of_its_code(room):
    assert f"::: {room}\n" in (DOCS / "code" / f"{room}.md").read_text()
