"""A check in a few lines of HTML, for notebooks: headline, what it means, what to do, and the plot of the law."""

from __future__ import annotations

import base64
from html import escape

from moireid.verifier.report.headline import Headline
from moireid.verifier.report.seconds import BANDS


def summary_html(headline: Headline, law_svg: bytes | None) -> str:
    """The lines; law_svg: as `law_plot` draws it, None where nothing was measured."""
    shown = ""
    if law_svg is not None:
        # As a picture: its style must not reach the notebook's page.
        source = f"data:image/svg+xml;base64,{base64.b64encode(law_svg).decode()}"
        shown = f'<img alt="place of the fringes over time, by the law and as seen" src="{source}">'
    return (
        f'<div style="border-left: 5px solid {BANDS[headline.colour]}; padding-left: 0.8em">'
        f"<strong>{headline.mark} {escape(headline.title)}</strong><br>{escape(headline.text)}<br>"
        f"<em>{escape(headline.advice)}</em></div>{shown}"
    )
