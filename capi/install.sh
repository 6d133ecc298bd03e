#!/usr/bin/env bash
# Builds librom and installs it with its headers, for pkg-config and CMake: capi/install.sh [--prefix DIR]
set -euo pipefail

prefix=/usr/local
while [ $# -gt 0 ]; do
    case $1 in
    --prefix) prefix=${2:?--prefix needs a folder}; shift 2 ;;
    --prefix=*) prefix=${1#--prefix=}; shift ;;
    *) echo "usage: capi/install.sh [--prefix DIR]   (default: $prefix)" >&2; exit 2 ;;
    esac
done
[ "$(uname -s)" = Linux ] || { echo "capi/install.sh is for Linux; elsewhere: cargo build --release -p rom-capi" >&2; exit 1; }
mkdir -p "$prefix"
prefix=$(cd "$prefix" && pwd)
source=$(cd "$(dirname "$0")" && pwd)
cd "$source/.."

target=$(cargo metadata --format-version 1 --no-deps --locked | python3 -c 'import json, sys; print(json.load(sys.stdin)["target_directory"])')
version=$(sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"/\1/p' Cargo.toml)
soversion=${version%.*}
# What a program linked with librom.a has to link besides: the compiler knows.
static_libs=$(cargo rustc --release --locked -p rom-capi --lib --crate-type staticlib -- --print native-static-libs 2>&1 |
    sed -n 's/^note: native-static-libs: //p' | tr ' ' '\n' | awk '!seen[$0]++' | tr '\n' ' ')
cargo build --release --locked -p rom-capi

fill() {
    sed -e "s|@VERSION@|$version|g" -e "s|@SOVERSION@|$soversion|g" -e "s|@STATIC_LIBS@|$static_libs|g" \
        -e "s|@CMAKE_STATIC_LIBS@|$(sed 's/-l//g; s/ *$//; s/ /;/g' <<<"$static_libs")|g" "$1" >"$2"
}
mkdir -p "$prefix"/include "$prefix"/lib/pkgconfig "$prefix"/lib/cmake/rom
install -m 644 "$source"/include/rom.h "$source"/include/rom.hpp "$prefix"/include/
install -m 755 "$target/release/librom.so" "$prefix/lib/librom.so.$version"
ln -sf "librom.so.$version" "$prefix/lib/librom.so.$soversion"
ln -sf "librom.so.$soversion" "$prefix/lib/librom.so"
install -m 644 "$target/release/librom.a" "$prefix/lib/"
fill "$source/cmake/rom.pc.in" "$prefix/lib/pkgconfig/rom.pc"
fill "$source/cmake/rom-config.cmake.in" "$prefix/lib/cmake/rom/rom-config.cmake"
fill "$source/cmake/rom-config-version.cmake.in" "$prefix/lib/cmake/rom/rom-config-version.cmake"
echo "installed librom $version in $prefix"
