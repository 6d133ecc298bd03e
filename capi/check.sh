#!/usr/bin/env bash
# Installs librom into a folder of its own, builds the examples against it by pkg-config and by CMake, with the shared and
# the static library, and runs them under valgrind: no error, no leak. For CI.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

missing() { command -v "$1" >/dev/null || { apt-get update -qq && apt-get install -y -qq "$2"; } >/dev/null; }
missing valgrind valgrind
missing pkg-config pkg-config
if ! command -v cmake >/dev/null; then
    python3 -m venv "$folder/venv"
    "$folder/venv/bin/pip" install --quiet cmake
    PATH="$folder/venv/bin:$PATH"
fi

capi/install.sh --prefix "$folder/usr"
# ROM_BIN: a folder with the two programs, where they have been built already.
tool() {
    local name=$1
    shift
    if [ -n "${ROM_BIN:-}" ]; then "$ROM_BIN/$name" "$@"; else cargo run --release --locked --quiet --bin "$name" -- "$@"; fi
}
tool romgen build models/fmb.toml -o "$folder/fmb.rom" >/dev/null

export PKG_CONFIG_PATH="$folder/usr/lib/pkgconfig" LD_LIBRARY_PATH="$folder/usr/lib"
strict="-O1 -g -Wall -Wextra -pedantic -Werror"
cflags=$(pkg-config --cflags rom)
static=$(pkg-config --libs --static rom | sed 's/-lrom/-l:librom.a/')
mkdir "$folder/bin"
# shellcheck disable=SC2086 # lists of flags
{
    cc -std=c99 $strict capi/examples/loop.c $cflags $(pkg-config --libs rom) -o "$folder/bin/loop"
    cc -std=c99 $strict capi/examples/loop.c $cflags $static -o "$folder/bin/loop-static"
    c++ -std=c++11 $strict capi/examples/run.cpp $cflags $(pkg-config --libs rom) -o "$folder/bin/run"
    c++ -std=c++11 $strict capi/examples/run.cpp $cflags $static -o "$folder/bin/run-static"
}
# shellcheck disable=SC2086
cc -std=c99 $strict capi/examples/strips.c $cflags $(pkg-config --libs rom) -lm -o "$folder/strips"
readelf -d "$folder/bin/loop" | grep -q 'librom.so.[0-9]' || { echo "the shared library has no name" >&2; exit 1; }
cmake -S capi/examples -B "$folder/cmake" -DCMAKE_PREFIX_PATH="$folder/usr" >/dev/null
cmake --build "$folder/cmake" >/dev/null

for program in "$folder"/bin/* "$folder"/cmake/{loop,run}-{rom,static}; do
    "$program" "$folder/fmb.rom" lc2 P >"$folder/$(basename "$program").txt"
done
for kind in loop run; do
    # The same code in every library: the same digits.
    for other in "$kind-static" "$kind-rom"; do
        cmp "$folder/$kind.txt" "$folder/$other.txt"
    done
done
for program in loop loop-static run run-static; do
    valgrind --quiet --leak-check=full --show-leak-kinds=all --errors-for-leak-kinds=all --error-exitcode=9 \
        "$folder/bin/$program" "$folder/fmb.rom" lc2 P
done
tool romgen build models/hale.toml --modes 8 -o "$folder/hale.rom" >/dev/null
valgrind --quiet --leak-check=full --show-leak-kinds=all --errors-for-leak-kinds=all --error-exitcode=9 \
    "$folder/strips" "$folder/hale.rom" gust wing | tail -1
# The C++ example prints what romrun finds.
tool romrun "$folder/fmb.rom" --loads lc2 --out "$folder/results" --no-report --quiet
python3 - "$folder" <<'PYTHON'
import csv, pathlib, re, sys
folder = pathlib.Path(sys.argv[1])
last = list(csv.DictReader(open(folder / "results/results.csv")))[-1]
expected = [float(last[f"P.dR_A.{c}"]) for c in "xyz"]
found = [float(x) for x in re.search(r"Newmark: +dR_A = \((.*)\)", (folder / "run.txt").read_text())[1].split(",")]
assert found == expected, f"{found} instead of {expected}"
print("C++ and romrun: the same bits")
PYTHON
