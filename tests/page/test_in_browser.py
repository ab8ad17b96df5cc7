"""The report in Chromium: what is seen without a click, how it is reached, and what a checker of accessibility says."""

import json
import re

import pytest

from tests.page.conftest import FOLDER, ROOT

WIDE, PHONE = (1280, 800), (390, 844)
SIZES = (PHONE, WIDE, (1440, 900))
_SHOWN = "document.querySelectorAll('#answer .models .shown')"
_VISIBLE_TABLE = f"[...{_SHOWN}].find(one => one.offsetParent !== null)"


def visible_rows(page):
    """(model, top, bottom, right, text) of the rows of the first screen's table."""
    return page.evaluate(
        f"[...{_VISIBLE_TABLE}.querySelectorAll('tbody tr')].map(row => {{ const box = row.getBoundingClientRect();"
        " return [row.querySelector('th').innerText.trim(), box.top, box.bottom, box.right, row.innerText] })"
    )


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("script", [True, False])
@pytest.mark.parametrize("size", SIZES, ids=str)
def test_nothing_scrolls_sideways_or_complains(opened, size, script, scheme):
    page = opened(*size, script=script, scheme=scheme)
    width, shown = page.evaluate("[document.documentElement.scrollWidth, document.documentElement.clientWidth]")
    assert width <= shown
    assert page.complaints == []
    assert [address for address in page.asked if not address.startswith(("file:", "data:", "blob:"))] == []
    red, green, blue = (
        int(part) for part in re.findall(r"\d+", page.evaluate("getComputedStyle(document.body).backgroundColor"))[:3]
    )
    assert (red + green + blue > 600) == (scheme == "light")


@pytest.mark.parametrize("script", [True, False])
def test_the_first_screen_answers_for_every_model(opened, script):
    """At 1280 x 800 without scrolling: every model, its error at 10^-2.5, what it costs there, and one word of advice."""
    page = opened(*WIDE, script=script)
    rows = visible_rows(page)
    assert len(rows) >= 9
    assert max(bottom for _, _, bottom, _, _ in rows) <= WIDE[1]
    assert max(right for _, _, _, right, _ in rows) <= WIDE[0]
    heads = page.evaluate(f"[...{_VISIBLE_TABLE}.querySelectorAll('thead th')].map(head => head.innerText)")
    assert {"−2.50", "at −2.50"} <= {head.strip() for head in heads} | {head.strip().replace("−2.5", "−2.50") for head in heads}
    assert all(re.search(r"\b(use|avoid)", text) for *_, text in rows)


def test_it_is_short(opened):
    """A phone shows a model without scrolling; folded it is few screens, and on paper few pages."""
    for size, most in ((WIDE, 4.0), (PHONE, 6.0)):
        page = opened(*size)
        assert visible_rows(page)[0][2] <= size[1]
        assert page.evaluate("document.documentElement.scrollHeight") / size[1] <= most
        assert len(page.evaluate("document.body.innerText").split()) < 2500
    assert len(re.findall(rb"/Type\s*/Page\b", opened(*WIDE).pdf(format="A4"))) <= 13
    assert (FOLDER / "index.html").stat().st_size < 2_000_000


def test_every_figure_has_a_number_in_words_and_a_csv(opened):
    page = opened(*WIDE)
    figures = page.evaluate(
        "[...document.querySelectorAll('figure.picture')].map(one => { const svg = one.querySelector('svg');"
        " const named = (svg.getAttribute('aria-labelledby') || '').split(' ').map(id => document.getElementById(id));"
        " return [one.id, named.map(part => part && part.textContent).join(' ') + (svg.getAttribute('aria-label') || ''),"
        " [...one.querySelectorAll('a')].map(a => [a.getAttribute('href'), a.download])] })"
    )
    assert len(figures) >= 5
    assert [name for name, words, _ in figures if not re.search(r"\d", words)] == []
    curves = {name: [link for link, _ in links if link.endswith(".csv")] for name, _, links in figures}
    assert [name for name, links in curves.items() if not links] == []
    assert [link for links in curves.values() for link in links if not (FOLDER / link).stat().st_size] == []


@pytest.mark.parametrize("unfolded", [False, True])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_an_accessibility_checker_has_nothing_serious_to_say(opened, scheme, unfolded):
    """axe-core, which knows nothing of this program."""
    from axe_playwright_python.sync_playwright import Axe

    page = opened(*WIDE, scheme=scheme)
    if unfolded:
        page.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
    found = Axe().run(page).response
    serious = [
        (rule["id"], node["html"][:120])
        for rule in found["violations"]
        if rule["impact"] in ("serious", "critical")
        for node in rule["nodes"]
    ]
    assert serious == []
    assert len(found["passes"]) > 15


@pytest.mark.parametrize("script", [True, False])
def test_one_click_shows_what_proves_a_number(opened, script):
    page = opened(*WIDE, script=script)
    page.locator("#answer .models .shown:visible td a").first.click()
    proof = page.locator(":target")
    proof.wait_for()  # until it is seen: the event that unfolds it comes after the click
    assert proof.locator("code").count() >= 1
    assert proof.locator("xpath=..").locator("th[scope=rowgroup] a[href^='#']").count() >= 1


@pytest.mark.parametrize("script", [True, False])
def test_one_click_shows_what_changed(opened, script):
    """Without a script it leads to the answer, whose details must be unfolded by hand."""
    page = opened(*WIDE, script=script)
    page.locator("header a[href='#changed']").click()
    if script:
        page.locator("#changed .caption").first.wait_for()
        assert "Compared with" in page.locator("#changed .caption").first.inner_text()
    else:
        summary = page.locator("#changed > summary")
        assert summary.is_visible()
        assert 0 <= summary.bounding_box()["y"] < WIDE[1]


def test_keys_alone_reach_everything(opened):
    """The first key leads past the head; arrows choose the quantity; Enter unfolds a question; focus is seen."""
    page = opened(*WIDE)
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.className") == "skip"
    for _ in range(40):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.type") == "radio":
            break
    before = page.evaluate(f"{_VISIBLE_TABLE}.className")
    page.keyboard.press("ArrowRight")
    assert page.evaluate(f"{_VISIBLE_TABLE}.className") != before
    page.locator("details.question > summary").nth(1).focus()
    assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") != "none"
    page.keyboard.press("Enter")
    assert page.evaluate("document.querySelectorAll('details.question')[1].open") is True


@pytest.mark.usefixtures("browser")
def test_report_json_obeys_the_published_schema():
    """By a validator that knows nothing of this program."""
    from jsonschema import Draft202012Validator

    schema = json.loads((ROOT / "docs/report.schema.json").read_text(encoding="utf-8"))
    Draft202012Validator.check_schema(schema)
    report = json.loads((FOLDER / "report.json").read_text(encoding="utf-8"))
    assert [error.message for error in Draft202012Validator(schema).iter_errors(report)][:3] == []
