"""shopping-list.csv, to be completed in a spreadsheet, and shopping-list.pdf, to be taken to the shop.

Prices that are not given stay empty in both.  The last row of the CSV file is the sum of the prices that are there.
"""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

from moireid.fabrication.page.canvas import BOLD, POINTS_PER_MM, REGULAR, register_fonts
from moireid.fabrication.shopping.mount_times import time_words
from moireid.fabrication.shopping.needs import ListLine, ShoppingList
from moireid.profiles import PAPERS_MM

HEADINGS = ("key", "what", "quantity", "unit", "unit_price", "total", "note", "source", "not_stated")
#: A spreadsheet computes what begins so.
FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")
MARGIN_MM, TITLE_POINTS, TEXT_POINTS, SMALL_POINTS = 15.0, 15.0, 8.5, 7.0
#: Widths of the table's columns, mm: what, quantity, price, total, note.
COLUMNS_MM = (62.0, 27.0, 16.0, 18.0, 57.0)
GREY, HEAD_GREY = 0.75, 0.92


def list_csv(found: ShoppingList) -> str:
    """The list as CSV text: a row a line, and the sum of the priced ones last."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(HEADINGS)
    for line in found.lines:
        words = [_plain(text) for text in (line.note, line.source, line.unstated)]
        figures = [_number(line.quantity), line.unit, _money(line.unit_price), _money(line.total)]
        writer.writerow([line.key, _plain(line.what), *figures, *words])
    writer.writerow(["total", "", "", "", "", _money(found.total), _plain(" ".join(heading_lines(found))), "", ""])
    return out.getvalue()


def heading_lines(found: ShoppingList) -> list[str]:
    """For what the list is, and what the mounts take, in sentences."""
    wish = found.wish
    x0, y0, x1, y1 = found.badge.outline_mm
    name = f" ({wish.form})" if wish.form else ""
    people = "1 badge" if wish.people == 1 else f"{wish.people:,} badges"
    lines = [
        f"{people} of {x1 - x0:g} x {y1 - y0:g} mm{name}, with {100 * wish.spare_share:g} % of everything to spare."
    ]
    if found.cutting is not None:
        plan = found.cutting
        sheets = "1 lens sheet" if plan.sheet_count == 1 else f"{plan.sheet_count:,} lens sheets"
        lines.append(f"{sheets} of {plan.sheet.across_mm:g} x {plan.sheet.along_mm:g} mm.")
    if found.mount is not None and found.hours is not None:
        lines.append(
            f"One mount prints for {time_words(found.mount.hours)} and takes {found.mount.grams:.3g} g; all of them "
            f"{time_words(found.hours)} on one printer."
        )
    if found.total is not None:
        without = [line.key for line in found.lines if line.total is None]
        rest = f", without {', '.join(without)}, which have no price" if without else ""
        lines.append(f"Total {found.total:,.2f}{rest}.")
    return lines


def write_list_csv(found: ShoppingList, path: Path) -> None:
    """Write the list as CSV in UTF-8 with a byte order mark, by which spreadsheets know it."""
    path.write_text(list_csv(found), encoding="utf-8-sig", newline="")


def write_list_pdf(found: ShoppingList, path: Path) -> None:
    """Write the list as pages of A4."""
    from reportlab.lib.colors import Color
    from reportlab.lib.styles import ParagraphStyle
    from reportlab.platypus import Paragraph, SimpleDocTemplate, Spacer, Table, TableStyle

    register_fonts()
    small = ParagraphStyle("small", fontName=REGULAR, fontSize=SMALL_POINTS, leading=1.25 * SMALL_POINTS)
    text = ParagraphStyle("text", small, fontSize=TEXT_POINTS, leading=1.3 * TEXT_POINTS)
    bold, right = ParagraphStyle("bold", text, fontName=BOLD), ParagraphStyle("right", text, alignment=2)
    title = ParagraphStyle("title", bold, fontSize=TITLE_POINTS, leading=1.5 * TITLE_POINTS)
    headings = [Paragraph(word, bold) for word in ("What", "Quantity", "Price", "Total", "Why so much")]
    rows: list[list[Any]] = [headings]
    for line in found.lines:
        figures = [Paragraph(escape(words), right) for words in (_money(line.unit_price), _money(line.total))]
        rows.append(
            [
                _what(line, text, small),
                Paragraph(escape(line.amount), text),
                *figures,
                Paragraph(escape(line.note), small),
            ]
        )
    rows.append([Paragraph("Total", bold), "", "", Paragraph(_money(found.total), right), ""])
    grid = Color(GREY, GREY, GREY)
    head = Color(HEAD_GREY, HEAD_GREY, HEAD_GREY)
    table = Table(rows, [wide * POINTS_PER_MM for wide in COLUMNS_MM], repeatRows=1)
    style: list[Any] = [("VALIGN", (0, 0), (-1, -1), "TOP"), ("LINEBELOW", (0, 0), (-1, -1), 0.4, grid)]
    table.setStyle(TableStyle([*style, ("BACKGROUND", (0, 0), (-1, 0), head)]))
    story: list[Any] = [
        Paragraph("Shopping list", title),
        *(Paragraph(escape(words), text) for words in heading_lines(found)),
    ]
    story += [Spacer(1, 4 * POINTS_PER_MM), table, Spacer(1, 4 * POINTS_PER_MM)]
    story += [Paragraph(escape(f"Note: {note}."), small) for note in found.notes]
    if found.cutting is not None:
        story.append(Paragraph("cutting-plan.pdf shows how the lens sheets are cut.", small))
    story.append(Paragraph("Prices that are empty were not given: fill them in from your shop's offer.", small))
    width, height = (side * POINTS_PER_MM for side in PAPERS_MM["a4"])
    margin = MARGIN_MM * POINTS_PER_MM
    page: dict[str, Any] = {"pagesize": (width, height), "invariant": 1, "title": "Shopping list", "creator": "moireid"}
    # Each page begins with a font set, which would else be a Helvetica that the file does not carry.
    page |= {"initialFontName": REGULAR}
    SimpleDocTemplate(
        str(path), leftMargin=margin, rightMargin=margin, topMargin=margin, bottomMargin=margin, **page
    ).build(story)


def _what(line: ListLine, text: Any, small: Any) -> list[Any]:
    """What to ask for, and below it where the figures are from and what is not stated."""
    from reportlab.platypus import Paragraph

    found = [Paragraph(escape(line.what), text)]
    if line.source:
        found.append(Paragraph(escape(f"Source: {line.source}."), small))
    if line.unstated:
        found.append(Paragraph(escape(f"Not stated: {line.unstated}."), small))
    return found


def _number(value: float) -> str:
    return f"{value:g}" if value < 1e5 else f"{value:.0f}"


def _money(value: float | None) -> str:
    return "" if value is None else f"{value:.2f}"


def _plain(words: str) -> str:
    """Text for a spreadsheet: quoted where it begins like a formula, which the spreadsheet would compute."""
    return f"'{words}" if words.startswith(FORMULA_STARTS) else words
