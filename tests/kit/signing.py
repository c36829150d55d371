"""Keys, certificates and a time authority, made for a test."""

from __future__ import annotations

import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from kit.programs import needs

Private = Ed25519PrivateKey | ec.EllipticCurvePrivateKey
DAY = timedelta(days=1)
TSA = """
[tsa]
default_tsa = it
[it]
serial = serial
signer_digest = sha256
default_policy = 1.2.3.4.1
digests = sha256, sha384, sha512
ess_cert_id_alg = sha256
"""


def new_key(kind: str) -> Private:
    """A private key: ed25519 or p256."""
    return Ed25519PrivateKey.generate() if kind == "ed25519" else ec.generate_private_key(ec.SECP256R1())


def pem_of(key: Private) -> bytes:
    return key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )


def public_pem_of(key: Private) -> bytes:
    form = serialization.PublicFormat.SubjectPublicKeyInfo
    return key.public_key().public_bytes(serialization.Encoding.PEM, form)


def certificate(
    name: str,
    key: Private,
    issuer: str,
    issuer_key: Private,
    *,
    authority: bool = False,
    purpose: x509.ObjectIdentifier = ExtendedKeyUsageOID.EMAIL_PROTECTION,
    begins: timedelta = -DAY,
    ends: timedelta = 30 * DAY,
) -> x509.Certificate:
    """A certificate as content credentials ask for it (C2PA 14.5), or one of an authority; begins, ends: from now."""

    def named(text: str) -> x509.Name:
        return x509.Name(
            [x509.NameAttribute(NameOID.ORGANIZATION_NAME, "House"), x509.NameAttribute(NameOID.COMMON_NAME, text)]
        )

    now, public, above = datetime.now(UTC), key.public_key(), issuer_key.public_key()
    usage = x509.KeyUsage(not authority, False, False, False, False, authority, authority, False, False)
    builder = (
        x509.CertificateBuilder(named(issuer), named(name), public, x509.random_serial_number())
        .not_valid_before(now + begins)
        .not_valid_after(now + ends)
        .add_extension(x509.BasicConstraints(authority, None), critical=True)
        .add_extension(usage, critical=True)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(public), critical=False)
        .add_extension(x509.AuthorityKeyIdentifier.from_issuer_public_key(above), critical=False)
    )
    if not authority:
        stamps = purpose == ExtendedKeyUsageOID.TIME_STAMPING
        builder = builder.add_extension(x509.ExtendedKeyUsage([purpose]), critical=stamps)
    return builder.sign(issuer_key, None if isinstance(issuer_key, Ed25519PrivateKey) else hashes.SHA256())


def pem_of_certificates(*certificates: x509.Certificate) -> bytes:
    return b"".join(one.public_bytes(serialization.Encoding.PEM) for one in certificates)


def certified_key(path: Path, kind: str, name: str = "Desk") -> Private:
    """A key with its certificate and its authority's in one file; the key is in the middle, as files may be so."""
    root, key = new_key("p256"), new_key(kind)
    own = certificate(name, key, "Root", root)
    above = certificate("Root", root, "Root", root, authority=True)
    path.write_bytes(pem_of_certificates(above) + pem_of(key) + pem_of_certificates(own))
    return key


@contextmanager
def time_authority(folder: Path) -> Iterator[tuple[str, Path]]:
    """An RFC 3161 authority on this machine, by openssl: its address, and the file of its root certificate."""
    openssl = needs("openssl")
    folder.mkdir()
    root, key = new_key("p256"), new_key("p256")
    (folder / "tsa.cnf").write_text(TSA)
    (folder / "serial").write_text("01\n")
    (folder / "key.pem").write_bytes(pem_of(key))
    own = certificate("Clock", key, "Clocks", root, purpose=ExtendedKeyUsageOID.TIME_STAMPING)
    (folder / "own.pem").write_bytes(pem_of_certificates(own))
    above = certificate("Clocks", root, "Clocks", root, authority=True)
    (folder / "root.pem").write_bytes(pem_of_certificates(above))
    command = [openssl, "ts", "-reply", "-config", "tsa.cnf", "-section", "it", "-queryfile", "q.tsq"]
    command += ["-inkey", "key.pem", "-signer", "own.pem", "-out", "r.tsr"]

    class Answer(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            (folder / "q.tsq").write_bytes(self.rfile.read(int(self.headers["Content-Length"])))
            subprocess.run(command, cwd=folder, check=True, capture_output=True)
            self.send_response(200)
            self.send_header("Content-Type", "application/timestamp-reply")
            self.end_headers()
            # A path that is asked for says what else is answered, for tests of bad authorities.
            reply = folder / self.path.strip("/")
            self.wfile.write((reply if reply.is_file() else folder / "r.tsr").read_bytes())

        def log_message(self, format: str, *arguments: object) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Answer)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/", folder / "root.pem"
    finally:
        server.shutdown()
        thread.join()
        server.server_close()
