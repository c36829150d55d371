"""Makes the fonts in src/moireid/fabrication/text/fonts from the Debian packages fonts-noto-core and fonts-roboto-slab.

    python .ci/fonts.py FOLDER        FOLDER: where the packages keep their fonts, such as /usr/share/fonts

Of each font the letters of its script are kept, with what a shaper needs to join, stack and place them; hints for
screens are left out.  The same packages give the same files.
"""

from __future__ import annotations

import sys
from pathlib import Path

from fontTools import subset

OUT = Path(__file__).parents[1] / "src/moireid/fabrication/text/fonts"
WEIGHTS = ("Regular", "Bold")
#: Latin, Greek, Cyrillic and their marks; punctuation, raised figures, currency and letter-like signs.
EUROPE = (
    (0x20, 0x7E), (0xA0, 0x24F), (0x250, 0x36F), (0x370, 0x3FF), (0x400, 0x52F), (0x1E00, 0x1EFF), (0x1F00, 0x1FFF),
    (0x2000, 0x206F), (0x2070, 0x209F), (0x20A0, 0x20CF), (0x2100, 0x214F), (0x2C60, 0x2C7F),
)  # fmt: skip
SIGNS = ((0x20, 0x40), (0x5B, 0x60), (0xA0, 0xA0), (0x200C, 0x200D), (0x2010, 0x201F), (0x25CC, 0x25CC))
#: The letters of Arabic that languages of today write with (Persian, Urdu, Pashto, Kurdish, Uyghur, Malay, Hausa).
ARABIC = ((0x600, 0x6FF), (0x750, 0x77F), (0x8A0, 0x8B4), *SIGNS)
FONTS = {
    "NotoSans": EUROPE,
    "NotoSerif": EUROPE,
    "RobotoSlab": EUROPE,
    "NotoSansArabic": ARABIC,
    "NotoNaskhArabic": ARABIC,
    "NotoSansHebrew": ((0x590, 0x5FF), (0xFB1D, 0xFB4F), *SIGNS),
    "NotoSerifHebrew": ((0x590, 0x5FF), (0xFB1D, 0xFB4F), *SIGNS),
    "NotoSansDevanagari": ((0x900, 0x97F), (0xA8E0, 0xA8FF), *SIGNS),
    "NotoSerifDevanagari": ((0x900, 0x97F), (0xA8E0, 0xA8FF), *SIGNS),
    "NotoSansBengali": ((0x964, 0x965), (0x980, 0x9FF), *SIGNS),
    "NotoSansTamil": ((0x964, 0x965), (0xB80, 0xBFF), *SIGNS),
    "NotoSansThai": ((0xE00, 0xE7F), *SIGNS),
    "NotoSansArmenian": ((0x530, 0x58F), (0xFB13, 0xFB17), *SIGNS),
    "NotoSansGeorgian": ((0x10A0, 0x10FF), (0x1C90, 0x1CBF), *SIGNS),
    "NotoSansEthiopic": ((0x1200, 0x139F), *SIGNS),
}


def make_font(source: Path, ranges: tuple[tuple[int, int], ...]) -> None:
    """Write the letters of one font."""
    options = subset.Options(layout_features=["*"], hinting=False, desubroutinize=False, notdef_outline=True)
    options.name_IDs = [0, 1, 2, 3, 4, 5, 6, 13, 14]
    options.name_languages = [0x409]
    options.glyph_names = False
    options.drop_tables += ["FFTM", "DSIG", "meta"]
    options.recalc_timestamp = False
    font = subset.load_font(str(source), options)
    cutter = subset.Subsetter(options)
    cutter.populate(unicodes=[code for first, last in ranges for code in range(first, last + 1)])
    cutter.subset(font)
    subset.save_font(font, str(OUT / source.name), options)
    print(f"{source.name}: {(OUT / source.name).stat().st_size} bytes, {len(font.getBestCmap())} letters")


def main() -> None:
    """Write all fonts."""
    folder = Path(sys.argv[1])
    for name, ranges in FONTS.items():
        for weight in WEIGHTS:
            (source,) = (path for path in folder.rglob(f"{name}-{weight}.[ot]tf"))
            make_font(source, ranges)


if __name__ == "__main__":
    main()
