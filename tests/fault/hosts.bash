# shellcheck shell=bash disable=SC2034,SC2154
# Hosts for a test, on one machine: network namespaces on a bridge, as machines at a switch. To be
# sourced after deploy/lib.bash, with `tools` set to the programs that the test needs: the script then goes on in
# namespaces of its own, with empty runs/ and keys/, and whatever it starts ends with it, however it
# ends.

test=$(basename "$0")
cd "$root" || exit

world=(unshare --pid --fork --kill-child --mount-proc --net --uts)
if [[ -z ${POWDERKEG_WORLD:-} ]]; then
  for tool in ip "${tools[@]}"; do
    if ! PATH=$PATH:/usr/sbin:/sbin command -v "$tool" >/dev/null; then
      echo "$test: skipped, there is no $tool"
      exit 77
    fi
  done
  if ! /usr/bin/python3 -c 'import h5py' 2>/dev/null; then  # Debian's
    echo "$test: skipped, python3-h5py is not installed"
    exit 77
  fi
  if ! "${world[@]}" ip link add name switch type bridge 2>/dev/null; then
    echo "$test: skipped, making namespaces and bridges takes root"
    exit 77
  fi
  mkdir -p runs keys
  POWDERKEG_WORLD=yes exec "${world[@]}" "$0" "$@"
fi

PATH=$PATH:/usr/sbin:/sbin
trap 'exit 1' INT TERM  # process 1 of a namespace has no default for them
for mounted in /run runs keys; do mount -t tmpfs -o mode=755 tmpfs "$mounted"; done
folder=/run/test
mkdir "$folder"
ip link add name switch type bridge
ip link set dev switch up

# add_host NAME NUMBER: a host with the addresses 10.77.0.NUMBER and fd77::NUMBER.
add_host() {
  ip netns add "$1"
  ip link add name "$1" type veth peer name eth0 netns "$1"
  ip link set dev "$1" master switch up
  ip -n "$1" address add "10.77.0.$2/24" dev eth0
  ip -n "$1" address add "fd77::$2/64" dev eth0 nodad
  ip -n "$1" link set dev lo up
  ip -n "$1" link set dev eth0 up
  echo "10.77.0.$2 $1" >>"$folder/hosts"
}
# Makes the names of all hosts known; once, when all are there.
name_hosts() { mount --bind "$folder/hosts" /etc/hosts; }
# on HOST COMMAND...
# shellcheck disable=SC2016
on() { nsenter --net="/run/netns/$1" unshare --uts bash -c 'hostname "$0" && exec "$@"' "$@"; }
# start NAME HOST COMMAND...: in the background as process[NAME]; its output goes to NAME.out.
declare -A process=()
start() {
  # shellcheck disable=SC2016
  nsenter --net="/run/netns/$2" unshare --uts bash -c 'hostname "$0" && exec "$@"' "${@:2}" \
    >>"$folder/$1.out" 2>&1 &
  process[$1]=$!
}
pull_cable() { ip link set dev "$1" down; }
plug_cable() { ip link set dev "$1" up; }

fail() {
  echo "$test: $1" >&2
  tail -n 30 "$folder"/*.out runs/*/log/* >&2 || true
  exit 1
}
# wait_for SECONDS WHAT COMMAND...
wait_for() {
  local deadline=$((SECONDS + $1)) what=$2
  shift 2
  until "$@"; do
    ((SECONDS < deadline)) || fail "timed out waiting for $what"
    sleep 0.1
  done
}
# count PATTERN FILE: how many lines have it.
count() { grep -cE -- "$1" "$2" 2>/dev/null || true; }
# said NUMBER PATTERN FILE: whether at least so many do.
said() { [[ $(count "$2" "$3") -ge $1 ]]; }
ended() { ! kill -0 "${process[$1]}" 2>/dev/null; }

# Of the run `run`:
iterations() { count '^[0-9]' "runs/$run/iterations.csv"; }
iterations_done() { [[ $(iterations) -ge $1 ]]; }
tickets() { /usr/bin/python3 tests/fault/stored_tickets.py "runs/$run/replay" | sort -n; }
# Iterations 1 to NUMBER are done, each once.
expect_iterations() {
  [[ $(grep '^[0-9]' "runs/$run/iterations.csv" | cut -d, -f1) == "$(seq "$1")" ]] ||
    fail "iterations.csv does not have iterations 1 to $1"
}
# expect_games TICKETS: the games that count are there, and those of TICKETS, and none twice.
expect_games() {
  local games all lost
  games=$(awk -F, '/^[0-9]/ { games += $2 } END { print games }' "runs/$run/iterations.csv")
  all=$(tickets)
  [[ -z $(uniq -d <<<"$all") ]] || fail "a game is stored twice"
  [[ $(head -n "$games" <<<"$all") == "$(seq 0 $((games - 1)))" ]] || fail "a game is missing"
  lost=$(comm -23 <(sort -u <<<"$1") <(sort <<<"$all"))
  [[ -z $lost ]] || fail "games are gone: $lost"
}
