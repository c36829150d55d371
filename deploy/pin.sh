#!/bin/sh
# pin.sh IMAGE: write by which digests the images are run, so that no tag can be moved under a deployment.
#
# It pulls Caddy and PostgreSQL, and IMAGE if its name begins with a registry's, by $ENGINE (docker, or podman), and writes
# images.env, for compose.  An image that was built here has no digest of a registry: it is run by its id, which names
# its content too.
set -eu

here=$(cd "$(dirname "$0")" && pwd)
image=${1:?usage: pin.sh IMAGE, such as moireid or registry.example.org/moireid:0.1.0}
engine=${ENGINE:-docker}

# pinned NAME: what stays the same image for ever.
pinned() {
    # A bare name is of an image that was built here; asked for elsewhere, it would be another's.
    case $1 in *.*/*) "$engine" pull --quiet "$1" > /dev/null ;; esac
    found=$("$engine" image inspect --format '{{if .RepoDigests}}{{index .RepoDigests 0}}{{else}}{{.Id}}{{end}}' "$1")
    case $found in
        *sha256:*) printf '%s\n' "$found" ;;
        # podman gives an id without its kind.
        *) printf 'sha256:%s\n' "$found" ;;
    esac
}

moireid=$(pinned "$image")
caddy=$(pinned docker.io/library/caddy:2)
postgres=$(pinned docker.io/library/postgres:17)
printf 'MOIREID_IMAGE=%s\nCADDY_IMAGE=%s\nPOSTGRES_IMAGE=%s\n' "$moireid" "$caddy" "$postgres" > "$here/images.env.new"
mv "$here/images.env.new" "$here/images.env"
echo "images.env is written"
