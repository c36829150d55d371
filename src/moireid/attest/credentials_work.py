"""The process that reads and writes content credentials, without the key.

Nothing here opens a network address: credentials that are stored elsewhere are not fetched.
"""

from __future__ import annotations

import base64
import json
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from moireid.errors import MediaError
from moireid.version import __version__

if TYPE_CHECKING:
    from moireid.sandbox.child import Talk

#: Of the assertion that holds a report.
LABEL = "org.moireid.verdict"
#: No network, and no remaking of pictures.
SETTINGS = {
    "verify": {"remote_manifest_fetch": False, "ocsp_fetch": False},
    "builder": {"thumbnail": {"enabled": False}},
}


@dataclass(frozen=True)
class CredentialRequest:
    """Credentials to be written: the film, the file to write, "sidecar" or "embed", the report, and who signs.

    algorithm: as c2pa names it; chain: certificates as PEM, the key's own first.
    """

    film: Path
    output: Path
    form: str
    report: dict[str, Any]
    algorithm: str
    chain: str


def write(talk: Talk) -> None:
    """The work of one process: write credentials.

    Raises: MediaError where the film's format has no credentials, or its own ones are damaged.
    """
    import c2pa

    asked: CredentialRequest = talk.next()

    def sign(claim: bytes) -> bytes:
        talk.send({"sign": base64.b64encode(claim).decode()})
        answer: bytes = talk.next()
        return answer

    try:
        context = c2pa.Context.from_dict(SETTINGS)
        builder = c2pa.Builder(_manifest(asked), context)
        builder.set_intent(c2pa.C2paBuilderIntent.EDIT)
        signer = c2pa.Signer.from_callback(sign, c2pa.C2paSigningAlg[asked.algorithm], asked.chain)
        if asked.form == "sidecar":
            builder.set_no_embed()
            # The library copies the film, even where it leaves it as it is.
            with asked.film.open("rb") as source, tempfile.TemporaryFile() as copy:
                asked.output.write_bytes(builder.sign(signer, _format(asked.film), source, copy))
        else:
            with asked.film.open("rb") as source, asked.output.open("w+b") as made:
                builder.sign(signer, _format(asked.film), source, made)
    except c2pa.C2paError as error:
        words = " ".join(str(error).split())[:200]
        raise MediaError(f"{asked.film} takes no content credentials ({words}); use a statement (attest)") from error


def read_back(talk: Talk) -> None:
    """The work of another process: send what is read in the file that the first one wrote."""
    asked: CredentialRequest = talk.next()
    aside = asked.form == "sidecar"
    talk.send((read(asked.film, asked.output.read_bytes()) if aside else read(asked.output)) or {})


def read(film: Path, manifest: bytes | None = None) -> dict[str, Any] | None:
    """The credentials of a film: their state by c2pa, and the report in them; None where none can be read.

    Parameters: manifest: those of a sidecar; None: those in the film.
    """
    import c2pa

    try:
        with film.open("rb") as stream:
            reader = c2pa.Reader(_format(film), stream, manifest, context=c2pa.Context.from_dict(SETTINGS))
            active = reader.get_active_manifest() or {}
            state, store = reader.get_validation_state(), json.loads(reader.crjson())
            # The reader's other outputs turn some lists of numbers into texts.
            manifests = [one for one in store["manifests"] if one["label"] == active.get("label")]
            verdict = manifests[0]["assertions"].get(LABEL) if manifests else None
    # Of damaged credentials the library's own errors are raised, and those of the JSON that it could not find or read.
    except (c2pa.C2paError, LookupError, ValueError, TypeError, AttributeError):
        return None
    return {"state": state, "verdict": verdict}


def _format(film: Path) -> str:
    return film.suffix.removeprefix(".").lower()


def _manifest(asked: CredentialRequest) -> str:
    generator = {"name": "moireid", "version": __version__}
    assertion = {"label": LABEL, "kind": "Json", "data": asked.report, "created": True}
    title, assertions = asked.film.name, [assertion]
    return json.dumps({"claim_generator_info": [generator], "title": title, "assertions": assertions})
