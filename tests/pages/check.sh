#!/bin/bash
# Manual pages and completions, as the tools that use them see them: groff finds nothing to warn of,
# three shells can parse and one can use them, and each option that --help names is in all.
# usage: check.sh PROGRAM PAGES [MPI-PROGRAM]     (needs groff-base, zsh and fish)
set -euo pipefail
program=$1
pages=$2
mpi_program=${3:-}
failed=0

check() {  # what, command
  local what=$1
  shift
  if ! "$@"; then
    echo "failed: $what"
    failed=$((failed + 1))
  fi
  checked=$((checked + 1))
}
checked=0

is_clean() {  # manual page
  local said
  said=$(groff -man -Tutf8 -ww -rCHECKSTYLE=3 "$1" 2>&1 >/dev/null)
  [ -z "$said" ] || { echo "$said"; return 1; }
}

completes() {  # words before the last, the last word, what is to be among the completions
  local found
  found=$(bash -c '
    source "$1"
    read -r -a COMP_WORDS <<<"$2"
    COMP_WORDS+=("$3")
    COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
    compopt() { :; }
    _ccvt
    printf "%s\n" "${COMPREPLY[@]}"' _ "$pages/completions/ccvt.bash" "$1" "$2")
  grep -qx -- "$3" <<<"$found"
}

names() {  # program, command: its long options, as its help has them
  "$1" "$2" --help | grep -oE -- '^  (-[a-z],)?--[a-z-]+' | grep -oE -- '--[a-z-]+'
}

commands_of() {
  "$1" --help | sed -n '/^Commands:/,/^$/s/^  \([a-z]*\) .*/\1/p'
}

commands=$(commands_of "$program")
[ -n "$commands" ]
for page in "$pages"/man1/*.1; do check "groff: $page" is_clean "$page"; done
check "bash" bash -n "$pages/completions/ccvt.bash"
check "zsh" zsh -n "$pages/completions/_ccvt"
check "fish" fish --no-execute "$pages/completions/ccvt.fish"
for command in $commands; do
  check "bash completes $command" completes "ccvt" "${command:0:3}" "$command"
  check "the main page names $command" grep -q "ccvt.-$command(1)" "$pages/man1/ccvt.1"
  check "$command has options" test -n "$(names "$program" "$command")"
  for option in $(names "$program" "$command"); do
    check "$command: bash completes $option" completes "ccvt $command" "$option" "$option"
    check "$command: zsh knows $option" grep -q -- "'$option\[" "$pages/completions/_ccvt"
    check "$command: fish knows $option" \
      grep -q -- "from $command'.* -l ${option#--} " "$pages/completions/ccvt.fish"
    check "$command: the manual has $option" \
      grep -qF -- "${option//-/\\-}" "$pages/man1/ccvt-$command.1"
  done
done
check "an option that takes a file is completed with files" \
  completes "ccvt tessellate" "$(dirname "$program")" "$(dirname "$program")"
if [ -n "$mpi_program" ]; then
  commands=$(commands_of "$mpi_program")
  [ -n "$commands" ]
  for command in $commands; do
    check "the page of ccvt-mpi names $command" \
      grep -q "ccvt.-mpi.-$command(1)" "$pages/man1/ccvt-mpi.1"
    for option in $(names "$mpi_program" "$command"); do
      check "ccvt-mpi $command: the manual has $option" \
        grep -qF -- "${option//-/\\-}" "$pages/man1/ccvt-mpi-$command.1"
    done
  done
fi
echo "$checked checked, $failed failed"
[ "$failed" -eq 0 ]
