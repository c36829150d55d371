"""Glyphs in a PDF: filled outlines, and over them the letters that they spell, without ink, for search and copying.

The letters are in a Type 3 font of empty glyphs, an em wide, each stretched over the glyphs that it stands for;
`ToUnicode` gives what it spells.  Programs that read text from a page turn letters that run from right to left by
themselves, from their places; so such a line has its letters as they are seen.

Source: ISO 32000-2, 9.6.4 (Type 3 fonts), 9.10.3 (ToUnicode).
"""

from __future__ import annotations

from typing import Any

from moireid.fabrication.text.fonts import face_of
from moireid.fabrication.text.outlines import outline_of
from moireid.fabrication.text.shaping import ShapedLine

#: Codes of a font; and the least width of letters, ems.
MOST_CODES, LEAST_EM = 256, 0.05


class LetterFont:
    """The codes of letters in one document; reportlab asks it for its objects when the document is written."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.codes: dict[str, int] = {}

    def addObjects(self, document: Any) -> None:
        """Add the font with the letters that were drawn."""
        from reportlab.pdfbase.pdfdoc import PDFArray, PDFDictionary, PDFName

        empty = document.Reference(_stream(document, "1000 0 0 0 1000 1000 d1"), f"empty:{self.name}")
        names = [f"g{code}" for code in self.codes.values()]
        font = {
            "Type": PDFName("Font"),
            "Subtype": PDFName("Type3"),
            "FontBBox": PDFArray([0, 0, 1000, 1000]),
            "FontMatrix": PDFArray([0.001, 0, 0, 0.001, 0, 0]),
            "CharProcs": PDFDictionary(dict.fromkeys(names, empty)),
            "Encoding": PDFDictionary(
                {"Type": PDFName("Encoding"), "Differences": PDFArray([0, *map(PDFName, names)])}
            ),
            "FirstChar": 0,
            "LastChar": len(names) - 1,
            "Widths": PDFArray([1000] * len(names)),
            "Resources": PDFDictionary({}),
            "ToUnicode": document.Reference(_stream(document, _to_unicode(self.codes)), f"letters:{self.name}"),
        }
        fonts = document.idToObject["BasicFonts"].dict
        fonts[self.name] = document.Reference(PDFDictionary(font), f"font:{self.name}")


def draw_line(canvas: Any, line: ShapedLine, size: float, x: float, y: float) -> None:
    """Draw a line of glyphs on a reportlab canvas in its fill colour; size, place of the line's start: points."""
    from reportlab.lib.rl_accel import fp_str

    lettered = [glyph.x_em for run in line.runs for glyph in run.glyphs if glyph.letters]
    ends = iter([*lettered[1:], line.width_em])
    for run in line.runs:
        per_em = face_of(run.font).upem
        for glyph in run.glyphs:
            place = x + glyph.x_em * size, y + glyph.y_em * size
            for sign, values in outline_of(run.font, glyph.number).steps:
                drawn = (place[k % 2] + size / per_em * value for k, value in enumerate(values))
                canvas._code.append(f"{fp_str(*drawn)} {sign}" if values else sign)
            canvas._code.append("f")
            if glyph.letters:
                font = _font_in(canvas._doc, glyph.letters)
                wide = max(next(ends) - glyph.x_em, LEAST_EM)
                canvas._code.append(
                    f"BT /{font.name} {fp_str(size)} Tf {fp_str(100 * wide)} Tz 1 0 0 1 {fp_str(place[0], y)} Tm "
                    f"<{font.codes[glyph.letters]:02X}> Tj 100 Tz ET"
                )


def _font_in(document: Any, letters: str) -> LetterFont:
    """The font of a document that has a code for letters; one is entered where it is new."""
    for known in document.delayedFonts:
        if isinstance(known, LetterFont) and (letters in known.codes or len(known.codes) < MOST_CODES):
            known.codes.setdefault(letters, len(known.codes))
            return known
    font = LetterFont(f"G{len(document.fontMapping) + 1}")
    document.fontMapping[f"letters {font.name}"] = f"/{font.name}"
    document.delayedFonts.append(font)
    return _font_in(document, letters)


def _stream(document: Any, content: str) -> Any:
    from reportlab.pdfbase import pdfdoc

    stream = pdfdoc.PDFStream(content=content.encode("ascii"))
    stream.filters = [pdfdoc.PDFZCompress] if document.compression else []
    return stream


def _to_unicode(codes: dict[str, int]) -> str:
    rows = [f"<{code:02X}> <{letters.encode('utf-16-be', 'surrogatepass').hex()}>" for letters, code in codes.items()]
    blocks = [rows[k : k + 100] for k in range(0, len(rows), 100)]
    body = "\n".join(f"{len(block)} beginbfchar\n" + "\n".join(block) + "\nendbfchar" for block in blocks)
    return (
        "/CIDInit /ProcSet findresource begin 12 dict begin begincmap\n"
        "/CIDSystemInfo << /Registry (Adobe) /Ordering (UCS) /Supplement 0 >> def\n"
        "/CMapName /Adobe-Identity-UCS def /CMapType 2 def\n"
        "1 begincodespacerange <00> <FF> endcodespacerange\n"
        f"{body}\nendcmap CMapName currentdict /CMap defineresource pop end end\n"
    )
