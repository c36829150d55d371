"""The page of what to buy.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import html
import json
import re

import pypdfium2
import pytest
from click.testing import CliRunner

from kit.webbing import OpenStudio, Visit
from moireid.cli.main import moireid

WISH = "format=a6&people=40&mount=lanyard&across_mm=210&along_mm=297"
FILES = ("shopping-list.pdf", "shopping-list.csv", "cutting-plan.pdf")


@pytest.fixture(scope="module")
def visit(open_studio: OpenStudio) -> Visit:
    return open_studio(work=False)


def words_of(page: str) -> str:
    return " ".join(html.unescape(re.sub(r"<[^>]+>", " ", page)).split())


def test_the_list_is_that_of_the_command_in_the_words_of_the_page(visit: Visit) -> None:
    """Catches: other quantities than the command's; a field that is lost; an option's name on a page."""
    page = visit.ask("GET", f"/issue/materials?{WISH}", "issuer")
    options = ["--format", "a6", "--people", "40", "--mount", "lanyard", "--sheet-size", "210x297", "--json"]
    outcome = CliRunner().invoke(moireid, ["materials", *options])
    found = re.findall(r'<td class="amount">([^<]*)</td><td>([^<]*)', page.text)
    lines = json.loads(outcome.stdout)["lines"]
    assert page.status_code == 200 and len(lines) == 5
    assert [html.unescape(what) for _, what in found] == [line["what"] for line in lines]
    assert [float(re.match(r"[\d.]+", amount)[0]) for amount, _ in found] == [line["quantity"] for line in lines]  # type: ignore[index]
    assert "are assumed" not in page.text and 'value="40"' in page.text
    assumed = visit.ask("GET", "/issue/materials?format=cr80&people=40", "issuer")
    assert "are assumed" in assumed.text and not re.search(r"(?<![\w-])--[a-z]{3,}", assumed.text)


def test_each_file_is_of_the_list_on_the_page(visit: Visit) -> None:
    """Catches: a link to another list; a file that no reader opens; a download that the browser shows as text."""
    page = visit.ask("GET", f"/issue/materials?{WISH}", "issuer")
    links = [html.unescape(link) for link in re.findall(r'href="(/issue/materials/[^"]+)" download', page.text)]
    answers = {name: visit.ask("GET", link, "issuer") for name, link in zip(FILES, links, strict=True)}
    for name, answer in answers.items():
        assert answer.status_code == 200 and f'attachment; filename="{name}"' == answer.headers["content-disposition"]
    assert "lens-sheet," in answers["shopping-list.csv"].content.decode("utf-8-sig")
    wanted = {"shopping-list.pdf": "11 sheets", "cutting-plan.pdf": "Sheets 1 to 10, all cut alike"}
    for name, words in wanted.items():
        text = pypdfium2.PdfDocument(answers[name].content)[0].get_textpage().get_text_range()
        assert words in text, name


def test_acrylic_is_listed_where_it_is_wished(visit: Visit) -> None:
    """Catches: a wish for acrylic that ends in a printed mount or in a holder from the shop."""
    page = visit.ask("GET", "/issue/materials?format=a6&people=3&mount=acrylic", "issuer").text
    assert "acrylic" in words_of(page[page.index('id="result"') :]) and "PLA" not in page


@pytest.mark.parametrize(
    ("query", "words"),
    [
        ("format=a6&people=0", "number of badges '0' cannot be used"),
        ("format=a6&people=10001", "number of badges '10001' cannot be used"),
        ("format=a6&people=some", "it is no number"),
        ("format=a6&across_mm=30&along_mm=30", "does not fit a sheet of 30 x 30 mm"),
        ("format=poster", "format 'poster' cannot be used"),
    ],
)
def test_a_fault_is_a_sentence_above_the_form(visit: Visit, query: str, words: str) -> None:
    """Catches: a bare error for a number that no event has; what was typed lost; a file of such a list."""
    page = visit.ask("GET", f"/issue/materials?{query}", "issuer")
    assert page.status_code == 422 and words in words_of(page.text), words_of(page.text)
    assert visit.ask("GET", f"/issue/materials/shopping-list.csv?{query}", "issuer").status_code == 422


def test_it_is_found_from_issue_and_is_for_issuers(visit: Visit) -> None:
    """Catches: a page that no other names; one that is open to all, who could keep the machine busy by it."""
    assert 'href="/issue/materials"' in visit.ask("GET", "/issue", "issuer").text
    assert 'aria-current="page">What to buy' in visit.ask("GET", "/issue/materials", "issuer").text
    for path in ("/issue/materials", f"/issue/materials/shopping-list.csv?{WISH}"):
        assert visit.ask("GET", path, "verifier").status_code == 403
        assert visit.ask("GET", path, None).status_code == 401
    assert visit.ask("GET", "/issue/materials/summary.csv", "issuer").status_code == 422
