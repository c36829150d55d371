"""Glyphs in a PDF as text: the fonts' outlines, and what each glyph spells, for search and copying.

A font goes into the file with the glyphs that are used: as a composite font whose codes are the numbers of its glyphs.
`ToUnicode` gives the letters of each; a glyph that stands for other letters at another place is in a second font.
Programs that read text from a page turn letters that run from right to left by themselves, from the places of their
glyphs; so such a line has its letters as they are seen, and a glyph without letters (a mark: they are with the glyph
below it) is a path.  Another line with such glyphs has its words as `ActualText`.

Source: ISO 32000-2, 9.7 (composite fonts), 9.10.3 (ToUnicode), 14.9.4 (ActualText).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import uharfbuzz

from moireid.fabrication.text.fonts import face_of
from moireid.fabrication.text.outlines import outline_of
from moireid.fabrication.text.shaping import Glyph, ShapedLine, hb_font


class PdfFont:
    """One font of one document; reportlab asks it for its objects when the document is written."""

    def __init__(self, font: Path, name: str) -> None:
        self.font, self.name = font, name
        self.letters: dict[int, str] = {}

    def addObjects(self, document: Any) -> None:
        """Add the font with the glyphs that were drawn."""
        from reportlab.pdfbase import pdfdoc

        face, font = face_of(self.font), hb_font(self.font)
        per_em = 1000.0 / face.upem
        true_type = "glyf" in face.table_tags
        data = _cut(face, set(self.letters))
        outlines = _stream(document, data if true_type else _table(data, "CFF "))
        if true_type:
            outlines.dictionary["Length1"] = len(data)
        else:
            outlines.dictionary["Subtype"] = pdfdoc.PDFName("CIDFontType0C")
        base = f"{_tag(self.letters)}+{self.font.stem}".replace(" ", "")
        extents = font.get_font_extents("ltr")
        descriptor = pdfdoc.PDFDictionary(
            {
                "Type": pdfdoc.PDFName("FontDescriptor"),
                "FontName": pdfdoc.PDFName(base),
                "Flags": 4,
                "FontBBox": pdfdoc.PDFArray([-1000, -1000, 2000, 2000]),
                "ItalicAngle": 0,
                "Ascent": round(extents.ascender * per_em),
                "Descent": round(extents.descender * per_em),
                "CapHeight": 700,
                "StemV": 80,
                "FontFile2" if true_type else "FontFile3": document.Reference(outlines, f"file:{self.name}"),
            }
        )
        widths: list[Any] = []
        for number in sorted(self.letters):
            widths += [number, pdfdoc.PDFArray([round(font.get_glyph_h_advance(number) * per_em, 2)])]
        within = {
            "Type": pdfdoc.PDFName("Font"),
            "Subtype": pdfdoc.PDFName("CIDFontType2" if true_type else "CIDFontType0"),
            "BaseFont": pdfdoc.PDFName(base),
            "CIDSystemInfo": pdfdoc.PDFDictionary(
                {
                    "Registry": pdfdoc.PDFString("Adobe"),
                    "Ordering": pdfdoc.PDFString("Identity"),
                    "Supplement": 0,
                }
            ),
            "FontDescriptor": document.Reference(descriptor, f"descriptor:{self.name}"),
            "W": pdfdoc.PDFArray(widths),
        }
        if true_type:
            within["CIDToGIDMap"] = pdfdoc.PDFName("Identity")
        spelled = _stream(document, _to_unicode(self.letters))
        whole = pdfdoc.PDFDictionary(
            {
                "Type": pdfdoc.PDFName("Font"),
                "Subtype": pdfdoc.PDFName("Type0"),
                "BaseFont": pdfdoc.PDFName(base),
                "Encoding": pdfdoc.PDFName("Identity-H"),
                "DescendantFonts": pdfdoc.PDFArray(
                    [document.Reference(pdfdoc.PDFDictionary(within), f"glyphs:{self.name}")]
                ),
                "ToUnicode": document.Reference(spelled, f"letters:{self.name}"),
            }
        )
        document.idToObject["BasicFonts"].dict[self.name] = document.Reference(whole, f"font:{self.name}")


def draw_line(canvas: Any, line: ShapedLine, size: float, x: float, y: float) -> None:
    """Draw a line of glyphs on a reportlab canvas in its fill colour; size, place of the line's start: points."""
    from reportlab.lib.rl_accel import fp_str

    parts, backwards = [], any(run.backwards for run in line.runs)
    for run in line.runs:
        shown: list[tuple[PdfFont, Glyph]] = []
        for glyph in run.glyphs:
            if glyph.letters or not backwards:
                shown.append((_font_in(canvas, run.font, glyph), glyph))
            else:
                parts.append(_outline(run.font, glyph.number, size, (x + glyph.x_em * size, y + glyph.y_em * size)))
        for font, level in itertools.groupby(shown, key=lambda one: (one[0], one[1].y_em)):
            first, *others = (glyph for _, glyph in level)
            place = fp_str(x + first.x_em * size, y + first.y_em * size)
            row = f"<{first.number:04X}>" + "".join(map(_after(run.font), [first, *others], others))
            parts.append(f"BT /{font[0].name} {fp_str(size)} Tf 1 0 0 1 {place} Tm [{row}] TJ ET")
    drawn = " ".join(parts)
    if not backwards and any(not glyph.letters for run in line.runs for glyph in run.glyphs):
        drawn = f"/Span <</ActualText <FEFF{_utf16(line.words)}>>> BDC {drawn} EMC"
    canvas._code.append(drawn)


def _after(font: Path) -> Callable[[Glyph, Glyph], str]:
    """Writes the glyph that follows another one: how far it is moved back from that one's end, and its code."""
    face, per_em = hb_font(font), 1000.0 / face_of(font).upem

    def follow(before: Glyph, glyph: Glyph) -> str:
        back = round(face.get_glyph_h_advance(before.number) * per_em - 1000.0 * (glyph.x_em - before.x_em), 2)
        return f" {back:g} <{glyph.number:04X}>" if back else f"<{glyph.number:04X}>"

    return follow


def _outline(font: Path, number: int, size: float, place: tuple[float, float]) -> str:
    """A glyph as a filled path."""
    from reportlab.lib.rl_accel import fp_str

    pen = outline_of(font, number)
    scale = size / face_of(font).upem
    rows = [
        f"{fp_str(*(place[k % 2] + scale * value for k, value in enumerate(values)))} {sign}".strip()
        for sign, values in pen.steps
    ]
    return " ".join([*rows, "f"]) if rows else ""


def _font_in(canvas: Any, path: Path, glyph: Glyph) -> PdfFont:
    """The font of the canvas's document in which a glyph has these letters; it is entered where it is new."""
    document = canvas._doc
    for known in document.delayedFonts:
        if not isinstance(known, PdfFont) or known.font != path:
            continue
        if known.letters.setdefault(glyph.number, glyph.letters) == glyph.letters:
            return known
    name = f"G{len(document.fontMapping) + 1}"
    font = PdfFont(path, name)
    font.letters[glyph.number] = glyph.letters
    document.fontMapping[f"glyphs {name}"] = f"/{name}"
    document.delayedFonts.append(font)
    return font


def _cut(face: uharfbuzz.Face, glyphs: set[int]) -> bytes:
    """The font with these glyphs alone, under their numbers."""
    wish = uharfbuzz.SubsetInput()
    flags = uharfbuzz.SubsetFlags
    wish.flags = flags.RETAIN_GIDS | flags.NO_HINTING | flags.CFF_IDENTITY_CHARSET | flags.DOWNGRADE_CFF2
    wish.glyph_set.update(glyphs | {0})
    wish.drop_table_tag_set.update(int.from_bytes(tag, "big") for tag in (b"GSUB", b"GPOS", b"GDEF"))
    if face.axis_infos:
        wish.pin_all_axes_to_default(face)
    return bytes(uharfbuzz.subset(face, wish).blob.data)


def _table(data: bytes, tag: str) -> bytes:
    """One table of a font's file."""
    return bytes(uharfbuzz.Face(uharfbuzz.Blob(data)).reference_table(tag).data)


def _stream(document: Any, data: bytes) -> Any:
    from reportlab.pdfbase import pdfdoc

    stream = pdfdoc.PDFStream(content=data)
    stream.filters = [pdfdoc.PDFZCompress] if document.compression else []
    return stream


def _tag(letters: dict[int, str]) -> str:
    """Six capitals that distinguish what was kept of a font (ISO 32000-2, 9.9.2)."""
    from hashlib import sha256

    digest = sha256(repr(sorted(letters)).encode()).digest()
    return "".join(chr(65 + byte % 26) for byte in digest[:6])


def _utf16(text: str) -> str:
    return text.encode("utf-16-be", "surrogatepass").hex().upper()


def _to_unicode(letters: dict[int, str]) -> bytes:
    rows = [f"<{number:04X}> <{_utf16(text)}>" for number, text in sorted(letters.items())]
    blocks = [rows[k : k + 100] for k in range(0, len(rows), 100)]
    body = "\n".join(f"{len(block)} beginbfchar\n" + "\n".join(block) + "\nendbfchar" for block in blocks)
    return (
        "/CIDInit /ProcSet findresource begin 12 dict begin begincmap\n"
        "/CIDSystemInfo << /Registry (Adobe) /Ordering (UCS) /Supplement 0 >> def\n"
        "/CMapName /Adobe-Identity-UCS def /CMapType 2 def\n"
        "1 begincodespacerange <0000> <FFFF> endcodespacerange\n"
        f"{body}\nendcmap CMapName currentdict /CMap defineresource pop end end\n"
    ).encode("ascii")
