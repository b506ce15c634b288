#!/bin/bash
# Installs a build into an empty folder, and builds and runs a project of another folder against it.
# usage: install_and_use.sh BUILD
set -euo pipefail
source_folder="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
cmake --install "$1" --prefix "$folder/marco" >/dev/null
cmake -S "$source_folder" -B "$folder/build" -DCMAKE_PREFIX_PATH="$folder/marco"
cmake --build "$folder/build"
"$folder/build/marco_user"
