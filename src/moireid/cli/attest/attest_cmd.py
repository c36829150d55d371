"""attest check: does a signed verdict hold, who gave it, when, and of which film?"""

from __future__ import annotations

import sys
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.common import (
    ACCEPT,
    REJECT,
    bundle_option,
    echo,
    friendly,
    json_option,
    report_standing,
    show_json,
    trust_option,
)
from moireid.cli.witness_options import WitnessCheck, witness_check
from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid.attest.checking import CheckResult
    from moireid.provenance import Standing
    from moireid.registry import Registry
    from moireid.registry.bundle.held import Bundle


#: Whom a check expected, in words.
EXPECTED = {
    "key": "the key that you gave",
    "certificate": "of the name that you gave, by an authority that you trust",
    "registry": "a key of the registry's authority",
}


@click.group("attest")
def attest_group() -> None:
    """Check signed verdicts."""


@attest_group.command("check")
@click.argument("envelope", metavar="FILE", type=click.Path(path_type=Path))
@click.option("--film", type=click.Path(path_type=Path), help="The film that it should be a verdict of.")
@click.option(
    "--key",
    "key_file",
    metavar="PUB.pem",
    type=click.Path(path_type=Path),
    help="The signer's public key or certificate, as you got it from the signer. The key in FILE itself proves "
    "nothing about who signed.",
)
@click.option(
    "--certificate-identity",
    "identity",
    metavar="NAME",
    help="The name in the signer's certificate: its common name, or an e-mail address, host or URI of it, letter by "
    "letter. Needs --certificate-authority, as anybody can make a certificate with any name.",
)
@click.option(
    "--certificate-authority",
    "issuer_file",
    metavar="CERT.pem",
    type=click.Path(path_type=Path),
    help="Certificates of the authorities that you trust to name the signer, for --certificate-identity.",
)
@click.option(
    "--registry",
    "registry_url",
    metavar="URL|FILE",
    help="Ask this registry whose badge it is, and whether it still counts.",
)
@bundle_option
@trust_option
@json_option
@friendly
@witness_check
def check_command(
    envelope: Path,
    film: Path | None,
    key_file: Path | None,
    identity: str | None,
    issuer_file: Path | None,
    registry_url: str | None,
    bundle_path: Path | None,
    trust: str | None,
    witness_check: WitnessCheck | None,
    as_json: bool,
) -> None:
    """Check a signed verdict: who judged what, and when?

    FILE is what `moireid verify --sign KEY.pem --attest FILE` wrote. Anybody can make a key, and sign in any name and
    of any day, so say whom you expect: --key, or --certificate-identity with --certificate-authority. Then no registry
    and no network are needed.

    With --registry or --bundle, the check also shows whether the badge is the person's, and whether it was revoked
    since: then the verdict does not hold. A registry says who holds a badge, and not who signed, unless its own
    authority did. Verdicts of all other signers need --key or --certificate-identity, too.

    The date is what the signer claims. To prove it, have FILE stamped by another program, as `openssl ts` does.

    Exit code 0: it holds; 1: it does not; 2: bad input, or nothing says whom to expect.
    """
    from moireid.api.asking import asked
    from moireid.attest.checking import check
    from moireid.attest.envelope import read_envelope
    from moireid.attest.signing_keys import load_certificates, load_public_key

    if witness_check is not None and registry_url is None and bundle_path is None:
        raise SpecError("--witness-key is of a registry, and none is asked; add --registry, or leave it out")
    if (identity is None) != (issuer_file is None):
        raise SpecError(
            "anybody can make a certificate with any name in it, so a name counts only by the word of an authority; "
            "give --certificate-identity and --certificate-authority together"
        )
    if key_file is None and identity is None and registry_url is None and bundle_path is None:
        raise SpecError(
            "nothing says whom to expect, and anybody can make a key, and sign in any name and of any day; give the "
            "signer's key, as you got it from the signer, by --key, or the name in the signer's certificate by "
            "--certificate-identity"
        )
    key = load_public_key(key_file) if key_file is not None else None
    trusted = load_certificates(issuer_file) if issuer_file is not None else ()
    found = check(read_envelope(envelope), film=film, key=key, identity=identity, authorities=trusted)
    if registry_url is not None or bundle_path is not None:
        require = witness_check.require if witness_check else None
        found = _held(found, asked(registry_url, bundle_path, trust, report_standing, require))
    if as_json:
        show_json(found.to_json())
    else:
        for line in lines_of(found):
            echo(line)
    sys.exit(ACCEPT if found.holds else REJECT)


def _held(found: CheckResult, place: AbstractContextManager[tuple[Registry | Bundle, Standing]]) -> CheckResult:
    """A verdict compared with what a registry or its bundle says of its badge, where it can be believed."""
    from moireid.api.asking import holder_in
    from moireid.attest.registry_answer import badge_of, held_against

    if found.report is None:
        return found
    if (badge_id := badge_of(found.report)) is None:
        raise SpecError(
            "this verdict names no identity, so no registry knows its badge; leave out --registry or --bundle"
        )
    with place as (held, _):
        holder, authority = holder_in(held)(badge_id), held.authority
    if holder is None:
        raise SpecError(f"no one there holds badge {badge_id}; name the registry that issued it")
    return held_against(found, holder, authority.fingerprint, authority.public_hex)


def lines_of(found: CheckResult) -> list[str]:
    """What a check found, for people."""
    document = found.to_json()
    faults = [f"  ✗ {fault.text}" for fault in found.faults]
    if found.report is None:
        return ["DOES NOT HOLD: nothing in it can be believed.", *faults]
    head = "HOLDS" if found.holds else "DOES NOT HOLD"
    film, badge = document["film"], document["badge"]
    whose = f"badge of {badge['name']} ({badge['id']})" if badge["id"] else f"board {badge['name']!r}"
    same = {True: "the given film is that film", False: "the given film is another", None: "no film was given"}
    return [
        f"{head}: {film['name']} was judged {document['verdict'].upper()}, {whose}",
        *faults,
        f"  film: SHA-256 {film['sha256']}; {same[film['same']]}{_track(film['tracks'])}",
        f"  who: {_who(document['signer'])}",
        f"  when: {document['time']}, by the signer's own clock, which the signer can set",
        f"  with: moireid {document['moireid']}",
        f"  registry: {_registry(document['registry'])}",
        *([f"  badge now: {_now(document['badge_now'])}"] if document["badge_now"] else []),
    ]


def _track(tracks: list[dict[str, Any]]) -> str:
    """Which of several video tracks was judged; empty for a film of one."""
    chosen = [str(track["index"]) for track in tracks if track["chosen"]]
    return f"; track {chosen[0]} of its {len(tracks)} video tracks was judged" if len(tracks) > 1 and chosen else ""


def _who(signer: dict[str, Any]) -> str:
    key = f"key {signer['key_sha256'][:32]}… ({signer['algorithm']})"
    what = " and ".join(EXPECTED[name] for name in signer["expected_by"])
    return f"{key}; it is {'' if signer['expected'] else 'not '}{what}"


def _now(now: dict[str, Any]) -> str:
    return "it still counts" if now["counts"] else f"revoked on {now['revoked_at']}"


def _registry(registry: dict[str, str | None] | None) -> str:
    if registry is None:
        return "none; the badge came from a file, and no one vouches for its name"
    until = f", by a bundle that counted until {registry['expires']}" if registry["expires"] else ""
    return f"of authority {registry['fingerprint']}, log at {registry['head']}{until}"
