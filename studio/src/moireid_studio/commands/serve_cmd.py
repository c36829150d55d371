"""serve: the studio on a port; token: who may use it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from moireid.cli.common import (
    FiniteRange,
    echo,
    friendly,
    json_option,
    registry_option,
    say,
    show_json,
    trust_option,
)
from moireid.cli.witness_options import witness_check
from moireid.errors import SpecError
from moireid.extras import missing_extra
from moireid.scheduler import is_loopback

data_option = click.option(
    "--data",
    "data",
    type=click.Path(path_type=Path, file_okay=False),
    help="The studio's folder, for tokens and for films while they are checked; default: in your user data folder.",
)


state_option = click.option(
    "--state",
    metavar="URL",
    help="A PostgreSQL database in place of files in the folder, for tokens and links.",
)


@click.command("serve")
@click.option("--host", default="127.0.0.1", metavar="ADDRESS", help="The address to listen on.")
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    default=8000,
    metavar="NUMBER",
    help="The port to listen on; 0 takes any free one.",
)
@click.option(
    "--public-url",
    envvar="MOIREID_PUBLIC_URL",
    metavar="URL",
    help="The address by which other people reach the studio, such as https://studio.example.org, for links that you "
    "send them. Without it, links begin with the address by which you have opened the studio.",
)
@registry_option
@trust_option
@click.option(
    "--keep-days",
    type=FiniteRange(0.001, 3650),
    default=1 / 24,
    show_default=False,
    metavar="DAYS",
    help="How long reports, measured captures and packages are kept; default: an hour. A film goes as soon as it is "
    "judged, and one that waits goes then too.",
)
@click.option(
    "--disk",
    "disk_gb",
    type=FiniteRange(0.1, 1e6),
    default=20.0,
    metavar="GB",
    help="The most that films and results may take; half of it may be one token's.",
)
@click.option(
    "--uploads-per-minute",
    type=click.IntRange(1),
    default=600,
    metavar="NUMBER",
    help="Films that one token of a verifier may send in a minute; others may send twice as many.",
)
@click.option(
    "--log",
    type=click.Choice(["text", "json"]),
    default="text",
    help="How to write the log to stderr: warnings as text; or these and each request, a line of JSON each. Neither "
    "names a person, a film or a token.",
)
@state_option
@click.option(
    "--workers",
    type=click.IntRange(1, 256),
    default=2,
    metavar="NUMBER",
    help="Films that are judged at a time, here or by the workers of --scheduler.",
)
@click.option(
    "--level",
    type=click.Choice(["record", "enrolled", "live"]),
    help="What a film or a live check must show to be accepted here, as for verify --level; with less it is "
    "inconclusive.",
)
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="A Dask scheduler, whose workers judge the films in the place of this machine: tls://HOST:PORT, with "
    "certificates in Dask's settings, or a loopback address. The workers have moireid-studio and its extra cluster.",
)
@click.option(
    "--worker-url",
    metavar="URL",
    help="The address by which the workers of --scheduler fetch their films from this studio; needed where they are "
    "on other machines. Use https:// where others could read along.",
)
@click.option("--no-auth", is_flag=True, help="Ask for no token. Allowed only on this machine's own address.")
@click.option(
    "--unsealed",
    is_flag=True,
    help="Also read films of strangers where this system cannot seal the process that reads them. A film made to take "
    "over its decoder then has the rights of this program.",
)
@data_option
@friendly
@witness_check
def serve_command(
    host: str,
    port: int,
    public_url: str | None,
    keep_days: float,
    disk_gb: float,
    uploads_per_minute: int,
    log: str,
    workers: int,
    worker_url: str | None,
    no_auth: bool,
    data: Path | None,
    **given: Any,
) -> None:
    """Run the studio: web pages and an API for all of this.

    Every user of the studio needs a token; make one with `moireid token create`. To try it on your own machine, use
    --no-auth, which asks for none.
    Without --registry, the default registry is used; it is made if there is none yet.
    With --checkpoint and --witness-key, each audit on the registry's page says which witnesses signed the newest
    checkpoint, and when. The file is read anew each time.
    """
    try:
        from moireid.registry.engine import own_file
        from moireid_studio.app import create_app
        from moireid_studio.auth.guard import address_parts
        from moireid_studio.http.addresses import checked_address
        from moireid_studio.http.logs import begin as begin_log
        from moireid_studio.http.server import serve
        from moireid_studio.settings import Limits, Settings, default_data, listening
    except ModuleNotFoundError as error:
        raise missing_extra("the studio", error.name or "a package", "", "moireid-studio") from error
    if no_auth and not is_loopback(host):
        raise SpecError(
            f"--no-auth would let everyone who reaches {host} do everything; use --host 127.0.0.1, or make tokens"
        )
    if no_auth and click.get_current_context().get_parameter_source("public_url") is ParameterSource.COMMANDLINE:
        raise SpecError("--no-auth answers this machine alone, so no one else could open --public-url; leave one out")
    # Without tokens the films are those of the one user of this machine, as on the command line.
    check_sealed(allowed=given["unsealed"] or no_auth)
    scheduler = given["scheduler"]
    if scheduler is not None and worker_url is None and not is_loopback(address_parts(scheduler).hostname or ""):
        raise SpecError(
            "workers of a scheduler elsewhere must reach this studio for their films; say how with --worker-url"
        )
    bound = listening(host, port)
    limits = Limits(
        keep_s=keep_days * 86400,
        disk_bytes=int(disk_gb * 1e9),
        uploads_a_minute=uploads_per_minute,
        workers=workers,
    )
    settings = Settings(
        data=data or default_data(),
        auth=not no_auth,
        limits=limits,
        worker_url=worker_url or f"http://127.0.0.1:{bound.getsockname()[1]}",
        # What is set for all commands does not concern a studio that only this machine reaches.
        public_url=None if no_auth or public_url is None else checked_address(public_url),
        # The other options have the names of a studio's settings.
        **given,
    )
    made = settings.registry_url is None and (file := own_file(None)) is not None and not file.exists()
    app = create_app(settings)
    shown = f"[{host}]" if ":" in host else host
    say(f"the studio is at http://{shown}:{bound.getsockname()[1]}/  (stop it with Ctrl-C)")
    say(_seal_words())
    registry = app.state.studio.registry
    if made:
        say(f"there was no registry, so a new one was made: {registry.shown_url}")
    elif not registry.count():
        say(f"no one is enrolled yet in its registry, {registry.shown_url}")
    begin_log(as_json=log == "json")
    serve(app, bound)


def check_sealed(*, allowed: bool) -> None:
    """Raise SpecError where this system does not seal the processes that read films, unless that is allowed."""
    from moireid.sandbox.process import sealed_here
    from moireid.sandbox.seal import missing

    if not allowed and (lacking := missing(sealed_here())) is not None:
        raise SpecError(
            f"a film's process {lacking} on this system, so films of strangers are not read here; use Linux 6.2 or "
            "newer with libseccomp, or add --unsealed if all films come from people whom you trust"
        )


def _seal_words() -> str:
    """What the process of a film can do, and cannot, on this system."""
    from moireid.sandbox.process import sealed_here
    from moireid.sandbox.seal import MEANS, missing

    held = sealed_here()
    words = f"a film's process {', '.join(MEANS[name] for name in held)}" if held else "a film's process is not sealed"
    return words if (lacking := missing(held)) is None else f"{words}; on this system it {lacking}"


@click.group("token")
def token_group() -> None:
    """Make, list and revoke access tokens for the studio."""


@token_group.command("create")
@click.option(
    "--role",
    type=click.Choice(["issuer", "verifier", "monitor", "admin"]),
    required=True,
    help="issuer: may issue, enroll and revoke; verifier: may verify films and live pictures; monitor: may "
    "read the figures at /metrics; admin: may do all.",
)
@click.option(
    "--note",
    default="",
    show_default=False,
    metavar="TEXT",
    help="Whose token it is, for your own list; the registry's log names it too.",
)
@click.option(
    "--expires",
    "days",
    type=FiniteRange(0.01, 3650),
    default=90.0,
    metavar="DAYS",
    help="After so many days it opens nothing any more.",
)
@data_option
@state_option
@json_option
@friendly
def token_create(role: str, note: str, days: float, data: Path | None, state: str | None, as_json: bool) -> None:
    """Make a token and print it.

    Copy it now: only its hash is kept, so it cannot be shown again.
    """
    from moireid_studio.auth.tokens import open_tokens

    with open_tokens(data, state) as tokens:
        secret, token = tokens.create(role, note, days)
    if as_json:
        document = {"token": secret, "id": token.id, "role": token.role, "note": token.note}
        show_json(document | {"made_at": token.made_at, "expires_at": token.expires_at})
        return
    click.echo(secret)
    say(
        f"this is the token with the id {token.id} and the role {token.role}, until {token.expires_at}; copy it, it "
        "cannot be shown again"
    )


@token_group.command("list")
@data_option
@state_option
@json_option
@friendly
def token_list(data: Path | None, state: str | None, as_json: bool) -> None:
    """List all tokens by id, role and note.

    The tokens themselves are not kept, so they are not shown.
    """
    from dataclasses import asdict

    from moireid_studio.auth.tokens import open_tokens

    with open_tokens(data, state) as tokens:
        found = tokens.all()
    if as_json:
        show_json({"tokens": [asdict(token) for token in found]})
        return
    for token in found:
        revoked = f"  revoked {token.revoked_at}" if token.revoked_at else ""
        times = f"{token.made_at}  until {token.expires_at}"
        echo(f"{token.id}  {times}  {token.role:<8}  {token.note}{revoked}".rstrip())


@token_group.command("revoke")
@click.argument("token_id", metavar="ID")
@data_option
@state_option
@json_option
@friendly
def token_revoke(token_id: str, data: Path | None, state: str | None, as_json: bool) -> None:
    """Revoke a token, at once and for good.

    ID is what `moireid token list` shows.
    """
    from moireid_studio.auth.tokens import open_tokens

    with open_tokens(data, state) as tokens:
        token = tokens.revoke(token_id)
    if as_json:
        show_json({"id": token.id, "role": token.role, "revoked_at": token.revoked_at})
    else:
        echo(f"token {token.id} ({token.role}) is revoked since {token.revoked_at}")
