"""What the page *Verify* is given of a claimed badge.  Next to each test: the wrong implementation it catches."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from kit.webbing import OpenStudio, Visit
from moireid.badge import Badge
from moireid.idcodes import specimen_of
from moireid.verifier.tracking.print_template import printer_of
from moireid_studio.pages.film_view import print_bytes, view_geometry


@pytest.fixture(scope="module")
def visit(open_studio: OpenStudio, ada: Badge) -> Visit:
    return open_studio(ada, work=False)


def test_a_verifier_learns_where_squares_and_a_row_are_and_no_line(visit: Visit, ada: Badge) -> None:
    """Catches: the badge's own pitches or id given to a visitor who knows a name; figures of another layout."""
    given = visit.ask("GET", f"/verify/view?claim={ada.name}", "verifier").json()
    assert given == json.loads(json.dumps(view_geometry(specimen_of(ada))))
    other = replace(specimen_of(ada, "0123456789abcdef"), name="Bob")
    assert {**given, "row": 0} == {**json.loads(json.dumps(view_geometry(other))), "row": 0}
    known, pitches = json.dumps(given), {cell.pitch_mm for grating in ada.gratings for cell in grating.cells}
    common = {cell.pitch_mm for grating in specimen_of(ada).gratings for cell in grating.cells}
    assert ada.id not in known and pitches - common and not any(str(pitch) in known for pitch in pitches - common)


@pytest.mark.parametrize("path", ["/verify/view?claim=Ada", "/verify/view/print?claim=Ada&px_per_mm=1"])
@pytest.mark.parametrize(("role", "status"), [(None, 401), ("issuer", 403), ("monitor", 403)])
def test_only_those_who_may_verify_ask(visit: Visit, path: str, role: str | None, status: int) -> None:
    """Catches: an open route that says who is enrolled."""
    assert visit.ask("GET", path, role).status_code == status


def test_a_claim_of_no_badge_gives_nothing(visit: Visit) -> None:
    """Catches: an error in the browser's console for each name that is not enrolled; a print of no badge."""
    answer = visit.ask("GET", "/verify/view?claim=Zoe", "verifier")
    assert (answer.status_code, answer.json()) == (200, None)
    assert visit.ask("GET", "/verify/view/print?claim=Zoe&px_per_mm=1", "verifier").status_code == 404
    for scale in ("0", "-1", "1e9", "nan"):
        assert visit.ask("GET", f"/verify/view/print?claim=Ada&px_per_mm={scale}", "verifier").status_code == 422


def test_the_print_is_the_verifier_s_template(visit: Visit, ada: Badge) -> None:
    """Catches: rows in another order, squares of unlike counts, a gradient per mm instead of per unit."""
    answer = visit.ask("GET", f"/verify/view/print?claim={ada.name}&px_per_mm=1.44", "verifier")
    assert answer.content == print_bytes(specimen_of(ada), 1.44)
    template = printer_of(ada.markers).draw(1.44)
    x, y, printed, across, down = np.frombuffer(answer.content, "<f4").reshape(5, -1)
    assert len(set(template.samples.count)) == 1 and np.allclose(np.stack([x, y], 1), template.samples.points)
    assert np.array_equal(printed, np.concatenate(template.printed))
    assert np.allclose(np.stack([across, down]), template.gradient() * template.extent)


def test_the_kernel_may_run_on_that_page_alone(visit: Visit) -> None:
    """Catches: a policy under which every page may compile code, or other code than the kernel's; a kernel that
    browsers refuse for its type.
    """
    for path in ("/", "/verify", "/live", "/call", "/registry"):
        policy = visit.ask("GET", path).headers["content-security-policy"]
        assert ("'wasm-unsafe-eval'" in policy) == (path == "/verify") and "'unsafe-" not in policy
    kernel = visit.ask("GET", "/static/kernel.wasm")
    assert kernel.headers["content-type"] == "application/wasm" and kernel.content[:4] == b"\0asm"
