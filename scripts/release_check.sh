#!/bin/sh
# Everything that a release must pass, up to the upload, which it leaves to you. Needs uv and an hour.
#
# The package is built; the sdist passes its own quick tests with the lock; the wheel, installed without the lock, runs
# a small experiment and its report on every Python it is for that is to be had, and with the lowest versions of all it needs.
# What a release lacks besides is told at the end, with exit status 1.
set -eu
cd "$(dirname "$0")/.."
PYTHONS="${PYTHONS:-3.11 3.12 3.13 3.14}"

fail() { echo "release: $*" >&2; exit 1; }

command -v uv >/dev/null || fail "uv is not to be found: install it"
version="$(.venv/bin/python -c 'import gsiirl; print(gsiirl.__version__)')"
lacking=""
lacks() { echo "release: $*" >&2; lacking=yes; }
[ -z "$(git status --porcelain)" ] || fail "the working tree holds changes: commit them"
grep -qE "^## \[$version\] - [0-9]{4}-" CHANGELOG.md || lacks "CHANGELOG.md has no heading [$version] with a date: give it one"
! git rev-parse --quiet --verify "refs/tags/v$version" >/dev/null || lacks "v$version is a tag already: raise the version"
grep -q '^\[project.urls\]' pyproject.toml || lacks "pyproject.toml has no [project.urls]: say where the repository is"
grep -q "version: $version\$" CITATION.cff || lacks "CITATION.cff is of another version than $version"
grep -q "version = {$version}" README.md || lacks "README's BibTeX is of another version than $version"

work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
.venv/bin/python -m hatchling build -d "$work/dist"
sdist="$(ls "$work"/dist/*.tar.gz)" wheel="$(ls "$work"/dist/*.whl)"
ls -lh "$work/dist"
tar xzOf "$sdist" --wildcards '*/PKG-INFO' > "$work/description"
grep -nP '\]\((?!https?:)' "$work/description" && lacks "the description has links that lead nowhere on a package index"

installed() { # name of the environment, then what to install into it
    name="$1"; shift
    uv pip install --quiet --python "$work/$name/bin/python" "$@"
}

tried() { # name of the environment
    name="$1"
    (cd "$work" && PATH="$work/$name/bin:$PATH" && gsiirl --version && gsiirl list >/dev/null \
        && gsiirl run security --graph small-linear --seeds 2 --iterations 4 --trajectories 20 --quiet --out "run-$name" \
        && gsiirl report "run-$name" --out "report-$name" >/dev/null && gsiirl table "run-$name" >/dev/null)
    echo "release: the wheel works in $name"
}

for python in $PYTHONS; do
    if uv venv --quiet --python "$python" "$work/newest-$python" 2>/dev/null; then
        installed "newest-$python" "$wheel"
        tried "newest-$python"
    else
        echo "release: Python $python is not to be had, and not tried"
    fi
done
uv venv --quiet --python 3.11 "$work/lowest-3.11"
# Of a wheel all that it needs counts as indirect, and would be taken as new as it comes.
installed "lowest-3.11" --resolution lowest-direct -r pyproject.toml
installed "lowest-3.11" --no-deps "$wheel"
tried "lowest-3.11"

mkdir "$work/sdist"
tar xzf "$sdist" -C "$work/sdist" --strip-components 1
make -C "$work/sdist" test

[ -z "$lacking" ] || fail "all tests pass, and what is named above is lacking"
echo "release: $version can be tagged (git tag v$version) and uploaded (uv publish dist/*); build it again from the tag"
