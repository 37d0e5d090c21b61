#!/usr/bin/env bash
# Prints each reason for which tests were skipped, and below it the tests: skipped_tests.sh [--ci] LOG..., the logs of ctest
# (Testing/Temporary/LastTest.log of a build tree) or of GTest. With --ci a reason other than absent data (../shared/data)
# is a failure: a missing program or module is to be installed, by scripts/install_packages.sh.
set -euo pipefail

ci=false
if [ "${1-}" = --ci ]; then ci=true; shift; fi
[ $# -gt 0 ] || { echo "usage: skipped_tests.sh [--ci] LOG..." >&2; exit 2; }

# GTest prints FILE:LINE: Skipped, the reason, and after an empty line the test. Here: lines REASON<tab>TEST.
skips=$(awk '
  /: Skipped$/ { reason = ""; reading = 1; next }
  /^\[  SKIPPED \] [^ ]+\.[^ ]+/ && reason != "" { sub(/,$/, "", $4); print reason "\t" $4; reason = ""; reading = 0; next }
  reading && /^$/ { reading = 0; next }
  reading { reason = reason (reason == "" ? "" : " ") $0 }
' "$@" | sort -u)

[ -n "$skips" ] || { echo "No test was skipped"; exit 0; }
echo "$(wc -l <<<"$skips") tests were skipped:"
awk -F '\t' '$1 != reason { reason = $1; print reason } { print "  " $2 }' <<<"$skips"
if [ "$ci" = true ] && grep -v '^[^	]*shared/data' <<<"$skips" >/dev/null; then
  echo "A test was skipped for a reason other than absent data:"
  grep -v '^[^	]*shared/data' <<<"$skips"
  exit 1
fi
