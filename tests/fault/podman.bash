# shellcheck shell=bash disable=SC2034,SC2154
# Images of what is built here, in a podman of our own that needs neither systemd nor the right to
# raise limits. To be sourced after deploy/lib.bash, with `tools` set to the other programs that the
# test needs; $1, if given, is the folder with the images of another time. Sets `storage`.

test=$(basename "$0")
storage=$(realpath "${1:-$(mktemp -d)}")
export CONTAINERS_CONF=$storage/containers.conf CONTAINERS_STORAGE_CONF=$storage/storage.conf

# Of packages of build/release, which run on this machine: the images stay on it.
make_images() {
  cpack --config "$root/build/release/CPackConfig.cmake" -B "$storage/packages" \
    -D CPACK_POWDERKEG_REFUSED= &>"$storage/cpack.log" || { tail "$storage/cpack.log" >&2; exit 1; }
  "$root/deploy/images" --packages "$storage/packages"
}
if [[ -z ${POWDERKEG_WORLD:-} ]]; then
  for tool in podman runc mmdebstrap dpkg-shlibdeps "${tools[@]}"; do
    command -v "$tool" >/dev/null || { echo "$test: skipped, there is no $tool"; exit 77; }
  done
  mkdir -p "$storage"
  cat >"$storage/containers.conf" <<'CONF'
[containers]
default_ulimits = ["nofile=1024:4096", "nproc=4096:4096"]
[engine]
cgroup_manager = "cgroupfs"
events_logger = "file"
runtime = "runc"
CONF
  printf '[storage]\ndriver = "overlay"\ngraphroot = "%s"\nrunroot = "%s"\n' \
    "$storage/images" "$storage/run" >"$storage/storage.conf"
  if ! said=$(podman info 2>&1 >/dev/null); then
    echo "$test: skipped, podman does not work here: $(tail -n 1 <<<"$said")"
    exit 77
  fi
  { podman image exists powderkeg-learner && podman image exists powderkeg-actor; } || make_images
fi
