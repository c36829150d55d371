"""generator-kit: what a user of a video generator needs to forge films of a badge."""

from __future__ import annotations

from pathlib import Path

import click

from moireid.cli.common import FolderPath, echo, friendly, json_option, overwrite_option, registry_option, show_json

#: The names of `evaluation.generator_kit.FORMATS`, written again because importing that room costs a second.
FORMATS = ("848x480", "1280x720", "1920x1080")


@click.group("generator-kit")
def generator_group() -> None:
    """Help to forge films with a video generator."""


@generator_group.command("cut")
@click.argument("manifest_csv", metavar="MANIFEST")
@click.option("--out", "folder", required=True, type=FolderPath(), help="Folder for the kit.")
@click.option(
    "--format",
    "formats",
    type=click.Choice(FORMATS),
    multiple=True,
    help="Size of the frames; may be given several times; default: all.",
)
@registry_option
@click.option(
    "--badge", "badge_json", type=click.Path(path_type=Path), help="The badge.json for films without a claim."
)
@overwrite_option
@json_option
@friendly
def cut_command(
    manifest_csv: str,
    folder: Path,
    formats: tuple[str, ...],
    registry_url: str | None,
    badge_json: Path | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Cut the first frames out of genuine films, and write the prompts.

    MANIFEST is a list as `moireid lab evaluate` reads it; its genuine films are taken. The kit has

    \b
    frames/      the first frame of each film at each size
    prompts.csv  prompts: the camera moves, the badge moves, both move
    clips.csv    the clips to be made, a line each
    clips/       where the clips are put
    films.csv    the list for `moireid lab evaluate`; add a line for each clip
                 that you keep

    Generators make 24 frames a second at 848x480 and 1280x720, and 25 at 1920x1080; clips.csv says so too.
    """
    from moireid.badge import load_badge
    from moireid_lab.evaluation.generator_kit import cut
    from moireid_lab.evaluation.manifest import read_manifest

    badge = load_badge(badge_json) if badge_json else None
    manifest = read_manifest(manifest_csv, registry_url=registry_url, badge=badge)
    files = cut(manifest, manifest_csv, folder, formats=formats or FORMATS, overwrite=overwrite)
    if as_json:
        show_json({"files": [str(path) for path in files]})
    else:
        echo(f"{len(files) - 3} frames in {folder / 'frames'}; make clips of them, and list them in {files[-1]}")
