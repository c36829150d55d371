"""The steps of a first badge, in their order: what can be done is done, and what comes next is said.

Each step has the files that it needs from the builder, and a function that does it.  A step whose inputs are as they
were when it was done is not done again.  A step that cannot be done ends the round: the next step is then to make its
files, or to make them better.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass

import msgspec

from moireid.bringup.badge_steps import AS_BUILT, print_first_badge, read_films
from moireid.bringup.build_folder import (
    BADGE_FILMS,
    BADGE_JSON,
    BY_HAND,
    CAMERA,
    PRINTED_FOR,
    SHEET_PHOTO,
    BuildFolder,
    Reading,
)
from moireid.bringup.chart_steps import CHART_FILES, PRINTER, SHEET, print_charts, read_charts
from moireid.errors import MoireIdError
from moireid.profiles import lens_named
from moireid.reading.film_orders import Progress
from moireid.reading.film_reader import Readers, film_reader
from moireid.sheets import MM_PER_INCH

#: How a step shows its progress: given what it does, a context that yields what counts frames.
Watch = Callable[[str], AbstractContextManager[Progress]]


def _quiet(_: str) -> AbstractContextManager[Progress]:
    return nullcontext(lambda done, of: None)


@dataclass(frozen=True)
class BuildStep:
    """One step.

    title, work: what the builder does, and what the program does meanwhile; ask: what the builder is to do for it, in
    plain words, with {folder}, {lens} and {paper}; needs: files of the builder, by their well-known names; made: files
    that it writes; own, wishes: files of other steps, and fields of the wish, that it depends on as well; once: whether
    it is done no more where its files are there, as a badge that is printed is never changed.
    """

    name: str
    title: str
    work: str
    do: Callable[[BuildFolder, Progress, Readers], Reading]
    ask: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
    made: tuple[str, ...] = ()
    own: tuple[str, ...] = ()
    wishes: tuple[str, ...] = ()
    once: bool = False

    def ready(self, folder: BuildFolder) -> bool:
        """Whether the builder's files are there."""
        return all(folder.found(name) for name in self.needs)

    def inputs(self, folder: BuildFolder) -> dict[str, str]:
        """What it depends on, as `BuildFolder.inputs`."""
        return folder.inputs(self.needs, self.own, self.wishes)

    def done(self, folder: BuildFolder) -> bool:
        """Whether it was done with the files that are there."""
        reading = folder.readings.get(self.name)
        if reading is None:
            return False
        written = reading.refused is None and all(folder.at(name).exists() for name in self.made)
        if self.once:
            return written
        return (written or reading.refused is not None) and reading.inputs == self.inputs(folder)


STEPS: tuple[BuildStep, ...] = (
    BuildStep(
        "charts",
        "Print the pitch test",
        "drawing the pitch test",
        print_charts,
        made=CHART_FILES,
        wishes=PRINTED_FOR,
    ),
    BuildStep(
        "sheet",
        "Photograph the pitch test",
        "reading the pitch test",
        read_charts,
        (
            "Buy a lenticular sheet of {lens}, 15 x 15 cm or more (shops for lenticular printing sell single sheets), "
            "clear tape, and heavy smooth paper of size {paper}. A laser printer of 600 dpi or more is best.",
            "Print {folder}/pitch-test.pdf at 100 % (“actual size”), and check with a ruler that both bars are 150 mm.",
            "Lay the sheet on the bands, ribs up and along the lines, so that the rows at the foot stay free. Turn it "
            "until the fringes are upright.",
            "From about 1 m, straight in front, in even daylight and without flash, take a photo with all four squares "
            "in it. Save it as {folder}/sheet-photo.jpg.",
            "Measure how thick the sheet is with a calliper, if you have one, and give it as --thickness.",
        ),
        needs=(SHEET_PHOTO,),
        made=(SHEET, PRINTER),
        wishes=BY_HAND,
    ),
    BuildStep("badge", "Print the badge", "drawing the badge", print_first_badge, made=(BADGE_JSON,), once=True),
    BuildStep(
        "films",
        "Film the badge twice",
        "reading the films of the badge",
        read_films,
        (
            "Print {folder}/badge/badge.pdf at 100 % on the same printer and paper, and build it as "
            "{folder}/badge/assembly.pdf shows. (If you measured the sheet again since, delete {folder}/badge "
            "first, and it is made anew.)",
            "Film it from about 1 m, in 1080p, without zoom and with stabilisation off, for ten seconds. Move the "
            "phone 20 cm to both sides, four times, and a little nearer and farther. Save it as "
            "{folder}/badge-film-1.mp4.",
            "Put the badge down, take it up again, and film it once more: {folder}/badge-film-2.mp4. Two films show "
            "how well the figures repeat. A camera that you calibrated (moireid calibrate --camera) is read of "
            "{folder}/camera.yaml.",
        ),
        needs=BADGE_FILMS,
        made=(AS_BUILT,),
        own=(CAMERA, BADGE_JSON),
        wishes=("thickness_mm",),
    ),
)


@dataclass(frozen=True)
class Advance:
    """A folder after a round: the steps that were done in it, and the step that is next, None at the end.

    refused: why the next step's files could not be used, None where they are not there yet.
    """

    folder: BuildFolder
    did: tuple[str, ...]
    next_step: BuildStep | None
    refused: str | None = None

    @property
    def ask(self) -> list[str]:
        """What the builder is to do, sentence by sentence."""
        if self.next_step is None:
            return ["All steps are done. Enter the badge into a registry with both films:", self._enroll()]
        wish, lens = self.folder.wish, lens_named(self.folder.wish.lens)
        sheet = f"{MM_PER_INCH / lens.pitch_mm:.4g} lenses to the inch, about {lens.thickness_mm:.2g} mm thick"
        return [one.format(folder=self.folder.path, lens=sheet, paper=wish.paper.upper()) for one in self.next_step.ask]

    def _enroll(self) -> str:
        at = self.folder.at
        films = [part for film in map(self.folder.found, BADGE_FILMS) for part in ("--capture", str(film))]
        camera = ["--camera", str(at(CAMERA))] if at(CAMERA).exists() else []
        return shlex.join(["moireid", "enroll", str(at(BADGE_JSON)), *films, *camera])


def advance(
    folder: BuildFolder, steps: Sequence[BuildStep] = STEPS, watch: Watch = _quiet, readers: Readers = film_reader
) -> Advance:
    """Do what can be done now, and keep it; the folder's state is saved before the first step and after each.

    Parameters
    ----------
    folder : BuildFolder
        As `open_folder` gives it.
    steps : sequence of BuildStep
        In their order.
    watch : callable, optional
        Shows the progress of a step, given what it does.
    readers : callable, optional
        Gives what reads photographs and films.

    Returns
    -------
    Advance
        The folder afterwards, and what comes next.

    Raises
    ------
    SpecError
        Where several files have one well-known name, or one has a format that cannot be read.
    """
    # What is wished counts next time as well, and a folder that a crash leaves is known as begun.
    folder.save()
    did: list[str] = []
    for step in steps:
        if not step.ready(folder):
            return Advance(folder, tuple(did), step)
        if not step.done(folder):
            # Files that cannot be used are a result too.
            try:
                with watch(step.work) as progress:
                    reading = step.do(folder, progress, readers)
            except MoireIdError as error:
                reading = Reading(refused=str(error))
            folder.readings[step.name] = msgspec.structs.replace(reading, inputs=step.inputs(folder))
            folder.save()
            did.append(step.name)
        refused = folder.readings[step.name].refused
        if refused is not None:
            return Advance(folder, tuple(did), step, refused)
    return Advance(folder, tuple(did), None)
