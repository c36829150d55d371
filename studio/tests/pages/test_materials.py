"""The page of what to buy.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import html
import re

import pypdfium2
import pytest

from kit.webbing import OpenStudio, Visit

WISH = "format=a6&people=40&mount=lanyard&across_mm=210&along_mm=297"
FILES = ("shopping-list.pdf", "shopping-list.csv", "cutting-plan.pdf")


@pytest.fixture(scope="module")
def visit(open_studio: OpenStudio) -> Visit:
    return open_studio(work=False)


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
