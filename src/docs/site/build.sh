#!/bin/bash
# Makes the documentation site: OUT/html. Fails for a warning of Doxygen's, a name of the interface of
# which nothing is said, a command of a guide that fails, an include that goes up, and a dead link.
# usage: build.sh PROGRAM OUT     (needs doxygen, dot and python3; about a minute)
set -euo pipefail
program=$(realpath "$1")
mkdir -p "$2"
out=$(cd "$2" && pwd)
cd "$(dirname "$0")/../../.."
site=src/docs/site
rm -rf "$out/html" "$out/xml" "$out/pictures"

python3 $site/commands.py "$program" README.md src/docs/*.md
$site/pictures.sh "$program" "$out/pictures"
python3 $site/filter.py --pictures "$out/pictures"
python3 $site/layers.py "$out/layers.dot"
dot -Tsvg "$out/layers.dot" -o "$out/pictures/layers.svg"

version=$("$program" --version | sed -n '1s/^ccvt //p')
{
  cat $site/Doxyfile
  echo "PROJECT_NUMBER = $version"
  echo "OUTPUT_DIRECTORY = \"$out\""
  echo "IMAGE_PATH = \"$out/pictures\""
} | doxygen -
python3 $site/api.py "$out/xml"

cp -r "$out/pictures/report" "$out/html/report"
python3 $site/filter.py --files | while read -r file; do
  mkdir -p "$out/html/files/$(dirname "$file")"
  cp "$file" "$out/html/files/$file.txt"
done
python3 $site/links.py "$out/html"
echo "The site is in $out/html/index.html."
