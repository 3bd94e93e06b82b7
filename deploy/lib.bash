# shellcheck shell=bash disable=SC2034
# What our scripts begin with; to be sourced first. `root` is the repository, wherever the script
# was called from and whatever links led to it.

# needs_bash MAJOR MINOR: ends the script where bash is older.
needs_bash() {
  local major minor
  IFS=. read -r major minor _ <<<"$BASH_VERSION"
  ((major > $1 || (major == $1 && minor >= $2))) && return
  echo "$(basename "$0"): bash is $BASH_VERSION, expected $1.$2 or newer" >&2
  exit 2
}
needs_bash 4 4  # for empty arrays under set -u

export LC_ALL=C.UTF-8  # numbers have points, and sort sorts alike, wherever this is
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
