"""Add to a list of parts what cyclonedx-py does not see: hashes, and what wheels carry inside.  For `make parts`.

    python .ci/parts.py LIST LOCK      by the Python of the environment of which the list was made

Of the studio, also the library of others that its pages bring (`make three`).

Of each package: the SHA-256 of each file of that version, of which one is installed, as the lock file has them.  Nested
in it: each shared library that its wheel for this platform brings, with the SHA-256 that the wheel states; and FFmpeg,
which PyAV and OpenCV each bring, by what their libraries report when they are asked.
"""

from __future__ import annotations

import base64
import ctypes
import hashlib
import importlib.metadata
import json
import re
import sys
from pathlib import Path
from typing import Any

Part = dict[str, Any]
#: Where a wheel's tool (auditwheel, delocate, delvewheel) puts libraries of others.
LIBRARIES = re.compile(r"(^|/)[^/]+\.(libs|dylibs)/[^/]+\Z")
FFMPEG = "https://ffmpeg.org/"
#: Licences of packages whose metadata names none by SPDX's identifiers: by the licence file in each, or of the source.
LICENCES = {
    "asttokens": "Apache-2.0",
    "cadquery-ocp": "Apache-2.0",
    "dlib-bin": "BSL-1.0",
    "ocpsvg": "Apache-2.0",
    "partd": "BSD-3-Clause",
    "resvg_py": "MIT",
    "uharfbuzz": "Apache-2.0",
}
#: The encoders in PyAV's wheel that are under the GPL; its FFmpeg reports itself as under the LGPL.
GPL = ("libx264", "libx265")
#: The library of the studio's pages, from where the list is.
THREE = Path("src/moireid_studio/static/three.js")


def locked(lock: Path) -> dict[tuple[str, str], list[str]]:
    """The SHA-256 of each package's files, by its name and version."""
    found: dict[tuple[str, str], list[str]] = {}
    for entry in re.split(r"\n(?=[a-z])", lock.read_text(encoding="utf-8")):
        if match := re.match(r"([a-z0-9.-]+)==([^\s;]+)", entry):
            found[match[1], match[2]] = sorted(set(re.findall(r"--hash=sha256:(\w+)", entry)))
    return found


def hashed(*digests: str) -> list[dict[str, str]]:
    """Digests as CycloneDX writes them."""
    return [{"alg": "SHA-256", "content": digest} for digest in digests]


def licensed(identifier: str) -> list[Part]:
    """A licence as CycloneDX writes it."""
    return [{"license": {"acknowledgement": "declared", "id": identifier}}]


def libraries(part: Part) -> list[Part]:
    """The shared libraries of others in an installed wheel, by name."""
    found = []
    for path in importlib.metadata.files(part["name"]) or ():
        if LIBRARIES.search(str(path)) and path.hash is not None:
            digest = base64.urlsafe_b64decode(path.hash.value + "=" * (-len(path.hash.value) % 4)).hex()
            own = {"licenses": licensed("GPL-2.0-or-later")} if path.name.startswith(GPL) else {}
            found.append({"type": "file", "name": path.name, "hashes": hashed(digest), **own})
    return sorted(found, key=lambda one: str(one["name"]))


def ffmpeg(part: Part) -> list[Part]:
    """FFmpeg and its libraries in PyAV's or OpenCV's wheel, as they report themselves."""
    version, parts = versions(part["name"])
    if version is None:
        return []
    ref = f"{part['bom-ref']}/ffmpeg"
    inside = [
        {"type": "library", "bom-ref": f"{ref}/{name}", "name": name, "version": number}
        for name, number in sorted(parts.items())
    ]
    return [
        {
            "type": "library",
            "bom-ref": ref,
            "name": "ffmpeg",
            "version": version,
            "purl": f"pkg:github/ffmpeg/ffmpeg@n{version}",
            "cpe": f"cpe:2.3:a:ffmpeg:ffmpeg:{version}:*:*:*:*:*:*:*",
            "licenses": licensed("LGPL-3.0-or-later" if part["name"] == "av" else "LGPL-2.1-or-later"),
            "externalReferences": [{"type": "website", "url": FFMPEG}],
            "components": inside,
        }
    ]


def versions(name: str) -> tuple[str | None, dict[str, str]]:
    """FFmpeg's version in a package, and those of its libraries; None and nothing where it brings none."""
    if name == "av":
        import av

        return str(av.ffmpeg_version_info), {
            library: ".".join(map(str, number)) for library, number in av.library_versions.items()
        }
    if name.startswith("opencv-"):
        import cv2

        inside = re.findall(r"^ +((?:av|sw)\w+): +YES \((\S+)\)", cv2.getBuildInformation(), re.MULTILINE)
        util = [path for path in importlib.metadata.files(name) or () if path.name.startswith("libavutil")]
        if not util or not inside:
            return None, {}
        library = ctypes.CDLL(str(util[0].locate()))
        library.av_version_info.restype = ctypes.c_char_p
        return library.av_version_info().decode(), {f"lib{library}": number for library, number in inside}
    return None, {}


def three(library: Path) -> Part:
    """The library that draws in 3D, as it states its version, with the SHA-256 of the bundled file."""
    content = library.read_bytes()
    (revision,) = re.findall(r'revision:"([0-9]+)"', content.decode())
    version = f"0.{revision}.0"
    return {
        "type": "library",
        "bom-ref": "three",
        "name": "three",
        "version": version,
        "purl": f"pkg:npm/three@{version}",
        "licenses": licensed("MIT"),
        "hashes": hashed(hashlib.sha256(content).hexdigest()),
    }


def main() -> None:
    path, lock = map(Path, sys.argv[1:])
    parts, digests = json.loads(path.read_text(encoding="utf-8")), locked(lock)
    for part in parts["components"]:
        name = re.sub(r"[-_.]+", "-", part["name"]).lower()
        part["hashes"] = hashed(*digests[name, part["version"]])
        if not part.get("licenses"):
            part["licenses"] = licensed(LICENCES[part["name"]])
        if inside := [*ffmpeg(part), *libraries(part)]:
            part["components"] = inside
    if (library := path.parent / THREE).is_file():
        # It is a part of the studio itself, and of none of its packages.
        parts["metadata"]["component"]["components"] = [three(library)]
    text = json.dumps(parts, indent=2, sort_keys=True)
    # A digest a line: there are thousands.
    text = re.sub(r'\{\s+("alg": "SHA-256"),\s+("content": "\w+")\s+\}', r"{\1, \2}", text)
    path.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
