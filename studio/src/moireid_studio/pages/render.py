"""Makes pages from templates.  Jinja2 escapes all values, and fails at a name that has no value."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import jinja2
from fastapi import Request
from fastapi.responses import HTMLResponse

from moireid import __version__
from moireid.verifier.report.page import template as report_template
from moireid_studio.auth.roles import visitor_of
from moireid_studio.auth.tokens import Role
from moireid_studio.problems import plain
from moireid_studio.studio import studio_of


@dataclass(frozen=True)
class Place:
    """An entry of the navigation, shown to the roles that may open it; without roles, to everybody."""

    path: str
    label: str
    roles: tuple[Role, ...] = ()


NAVIGATION = (
    Place("/issue", "Issue", ("issuer",)),
    Place("/enroll", "Enroll", ("issuer",)),
    Place("/verify", "Verify", ("verifier",)),
    Place("/live", "Live", ("verifier",)),
    Place("/call", "Call", ("verifier",)),
    Place("/links", "Links", ("verifier",)),
    Place("/registry", "Registry", ("issuer", "verifier")),
    Place("/verdicts", "Verdicts", ("admin",)),
    Place("/help", "Help"),
)

_environment = jinja2.Environment(
    # The parts of a verdict are those of the report's own page.
    loader=jinja2.ChoiceLoader([jinja2.PackageLoader("moireid_studio"), jinja2.FunctionLoader(report_template)]),
    autoescape=True,
    undefined=jinja2.StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)
#: Sentences of the library about what was not made.
_environment.filters["plain"] = plain


def render(request: Request, template: str, *, status: int = 200, **context: Any) -> HTMLResponse:
    """The page that `templates/TEMPLATE` makes of `context`; base.html.j2 also gets navigation and visitor."""
    visitor = visitor_of(request)
    path = request.url.path
    shown = [place for place in NAVIGATION if not place.roles or (visitor is not None and visitor.may(*place.roles))]
    page = _environment.get_template(template).render(
        navigation=shown,
        here=path,
        visitor=visitor,
        auth=studio_of(request).settings.auth,
        version=__version__,
        **context,
    )
    return HTMLResponse(page, status)
