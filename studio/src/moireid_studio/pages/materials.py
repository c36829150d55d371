"""What to buy for badges: a list on a page, and its files to download; nothing is kept.

An order is in the address, so that a list can be found again, and each file is made when it is asked for.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Annotated, Any, Literal
from urllib.parse import urlencode

from fastapi import APIRouter, Request
from fastapi.responses import Response
from pydantic import BaseModel, Field

from moireid.errors import MoireIdError
from moireid.fabrication.shopping.shopping_files import file_names, write_shopping
from moireid.fabrication.shopping.shopping_list import MOST_PEOPLE, ShoppingList
from moireid.shopping import ASSUMED_MM, list_for, usual_badge
from moireid_studio.auth.guard import Visitor, require
from moireid_studio.jobs.orders import FormatName, Millimetres, Mount, read_fields
from moireid_studio.pages.home import render
from moireid_studio.pages.issue_pages import CHOICES
from moireid_studio.problems import Refusal
from moireid_studio.studio import studio_of

#: The files of a list: their kind, and what the page calls them.
FILES = {
    "shopping-list.pdf": ("application/pdf", "Shopping list, PDF"),
    "shopping-list.csv": ("text/csv; charset=utf-8", "Shopping list, CSV for a spreadsheet"),
    "cutting-plan.pdf": ("application/pdf", "Cutting plan of the lens sheets, PDF"),
}
FileName = Literal["shopping-list.pdf", "shopping-list.csv", "cutting-plan.pdf"]


class MaterialsOrder(BaseModel):
    """For which badges, as `moireid materials` takes them; what is left out is as there."""

    format: FormatName = "a6"
    people: int = Field(1, ge=1, le=MOST_PEOPLE)
    mount: Mount | Literal["acrylic"] | None = None
    spare_percent: float = Field(5.0, ge=0, le=100, allow_inf_nan=False)
    across_mm: Millimetres | None = None
    along_mm: Millimetres | None = None

    def listed(self) -> ShoppingList:
        """The shopping list.  Raises: SpecError, FabricationError or DesignError, as the command does."""
        sheet_mm = None
        if self.across_mm is not None or self.along_mm is not None:
            sheet_mm = (self.across_mm or ASSUMED_MM[0], self.along_mm or ASSUMED_MM[1])
        spare_share, badge = self.spare_percent / 100, usual_badge(self.format)
        return list_for(badge, self.people, mount=self.mount, spare_share=spare_share, sheet_mm=sheet_mm)


router = APIRouter(prefix="/issue/materials", include_in_schema=False)
Issuer = Annotated[Visitor, require("issuer")]


@router.get("")
def materials_page(request: Request, visitor: Issuer) -> Response:
    """The form, and below it the list where one was asked for."""
    given = dict(request.query_params)
    if "format" not in given:
        return _page(request, given)
    try:
        found = _order(given).listed()
    except MoireIdError as error:
        return _page(request, given, status=422, problem=studio_of(request).sentence(error))
    files = [(f"/issue/materials/{name}?{urlencode(given)}", FILES[name][1]) for name in file_names(found)]
    return _page(request, given, found=found, files=files)


@router.get("/{name}")
def materials_file(request: Request, name: FileName, visitor: Issuer) -> Response:
    """One of the list's files."""
    found = _order(dict(request.query_params)).listed()
    with tempfile.TemporaryDirectory(prefix="moireid-") as folder:
        made = write_shopping(found, Path(folder))
        if name not in made:
            raise Refusal(404, "no_plan", "These badges have no lens sheet that is cut, so there is no cutting plan.")
        headers = {"Content-Disposition": f'attachment; filename="{name}"'}
        return Response(made[name].read_bytes(), media_type=FILES[name][0], headers=headers)


def _order(given: dict[str, str]) -> MaterialsOrder:
    """The order of an address.  Raises: SpecError that names the first field which cannot be used."""
    order: MaterialsOrder = read_fields(MaterialsOrder, given)
    return order


def _page(request: Request, given: dict[str, str], *, status: int = 200, **shown: object) -> Response:
    context: dict[str, Any] = {"problem": None, "found": None, "files": [], "assumed": ASSUMED_MM}
    context |= {"most": MOST_PEOPLE} | CHOICES | shown
    return render(request, "materials.html.j2", status=status, given=given, **context)
