"""A film judged, and the outcome: as text, as a page, as arrays and as a plot."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from moireid.errors import SpecError
from moireid.files import AnyPath, as_path
from moireid.question import Question
from moireid.reading.film_reports import judged_film
from moireid.verifier.report.circumstances import Circumstances
from moireid.verifier.report.headline import Headline, headline_of
from moireid.verifier.report.report_page import LAW, Pictures, write_pages
from moireid.verifier.report.summary import summary_html

if TYPE_CHECKING:
    from moireid.api.asking import LookUp
    from moireid.reading.film_orders import Progress
    from moireid.reading.film_reader import Reader
    from moireid.verifier.signal_table import SignalTable


@dataclass(frozen=True, repr=False)
class FilmCheck:
    """What a film shows of a badge: the outcome of `verify` or `identify`.

    Parameters
    ----------
    document : dict
        What ``verify --json`` or ``identify --json`` prints.
    known : Circumstances
        How the check was made, and what the registry says.
    pictures : Pictures
        Of the report's page, and the signals; none for `identify`.
    """

    document: dict[str, Any]
    known: Circumstances
    pictures: Pictures

    @property
    def verdict(self) -> str:
        """The outcome: "accept", "reject" or "inconclusive"; of `identify` "found", "nobody" or "inconclusive"."""
        return str(self.document.get("finding") or self.document["verdict"])

    @property
    def accepted(self) -> bool:
        """Whether the film was accepted, or an enrolled badge was found in it."""
        return self.verdict in ("accept", "found")

    @property
    def found_id(self) -> str | None:
        """The enrolled badge that `identify` found; None otherwise."""
        return self.document.get("found_id")

    @property
    def found_name(self) -> str | None:
        """The name of who holds that badge, according to the registry; None otherwise."""
        return self.document.get("found_name")

    @property
    def reasons(self) -> list[dict[str, Any]]:
        """The findings, each with code, level, measured value, limit, unit and text."""
        return list(self.document["reasons"])

    @cached_property
    def headline(self) -> Headline:
        """The result in one line, what it means, and what to do next."""
        return headline_of(self.document, self.known)

    def to_json(self) -> dict[str, Any]:
        """Give the object that the command prints with ``--json``.

        Returns
        -------
        dict
            As `moireid.json_schema.report_schema` describes it.
        """
        return self.document

    def signals(self) -> SignalTable:
        """Give time, camera and phases of the frames that were judged.

        Returns
        -------
        SignalTable
            Arrays (T,) by the column names of signals.csv.

        Raises
        ------
        SpecError
            Of an `identify`, and of a `verify` without pictures, which keep no signals.
        """
        if not self.pictures.signals:
            raise SpecError("this check kept no signals; call verify with pictures=True, which is its default")
        from moireid.verifier.signal_table import SignalTable

        return SignalTable.from_csv(self.pictures.signals)

    def plot(self, grating: int | None = None) -> Any:
        """Draw the measured phase of the fringes against the one that optics predict.

        Parameters
        ----------
        grating : int, optional
            Its number; None for the one whose predicted phase moves most.

        Returns
        -------
        matplotlib.figure.Figure
            Both over time, and one against the other.

        Raises
        ------
        SpecError
            As `signals`, and for a grating that the badge does not have.
        """
        from moireid.verifier.report.phase_figure import phase_figure

        return phase_figure(self.signals(), grating)

    def write(self, folder: AnyPath, *, overwrite: bool = False) -> list[Path]:
        """Write the report for people, the same as JSON, and the signals, as ``verify --report`` does.

        Parameters
        ----------
        folder : str or Path
            Made where it is absent.
        overwrite : bool
            Whether older files may be replaced.

        Returns
        -------
        list of Path
            report.html, report.json and signals.csv.

        Raises
        ------
        SpecError
            Where a file would be replaced; and as `signals`.
        """
        self.signals()
        return write_pages(self.document, self.pictures, self.known, as_path(folder), overwrite=overwrite)

    def __repr__(self) -> str:
        return f"FilmCheck({self.verdict}: {self.headline.title})"

    def _repr_html_(self) -> str:
        """For notebooks: headline, advice and the plot of the law."""
        return summary_html(self.headline, self.pictures.files.get(LAW))


def judge(
    film: Path, question: Question, look_up: LookUp, reader: Reader, progress: Progress, *, pictures: bool
) -> FilmCheck:
    """Judge a film by a reader, and look its report up where the claim was.

    Raises: MoireIdError as `judged_film`.
    """
    made = judged_film(film, question, reader, progress, pictures=pictures)
    return FilmCheck(made.result, look_up(made.result), made.pictures)
