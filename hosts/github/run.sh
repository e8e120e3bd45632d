#!/bin/sh
# What the GitHub Action does (action.yml): annotations to the log, the page of the run, SARIF and a comment for files.
#   OLP_CHECK, OLP_LINT   paths, separated by blanks; empty: not done
#   OLP_BASELINE          file of known mistakes (olp lint --write-baseline); empty: none
#   OLP_DIFF              revision to compare with; empty: the base of the pull request; none: not done
#   OLP_SARIF             folder for check.sarif and lint.sarif; empty: none
#   OLP_COMMENT           file for the comparison in Markdown
# The exit status is the worst: 0 held, 1 a finding, 2 something could not be judged.
set -f # paths hold no patterns: olp expands its own
worst=0

annotated() { # one command, told three ways
  command=$1
  shift
  page=${RUNNER_TEMP:-.}/olp-$command.md
  [ -z "$GITHUB_STEP_SUMMARY" ] || set -- "$@" --also "markdown=$page"
  if [ -n "$OLP_SARIF" ]; then
    mkdir -p "$OLP_SARIF"
    set -- "$@" --also "sarif=$OLP_SARIF/$command.sarif"
  fi
  olp "$command" "$@" --format github
  status=$?
  [ "$status" -le "$worst" ] || worst=$status
  [ -z "$GITHUB_STEP_SUMMARY" ] || cat "$page" >>"$GITHUB_STEP_SUMMARY"
  rm -f "$page"
}

# shellcheck disable=SC2086 # the inputs are lists
[ -z "$OLP_CHECK" ] || annotated check $OLP_CHECK ${GITHUB_BASE_REF:+--no-cache} # a pull request brings no verdicts
# shellcheck disable=SC2086
[ -z "$OLP_LINT" ] || annotated lint $OLP_LINT ${OLP_BASELINE:+--baseline "$OLP_BASELINE"}

base=$OLP_DIFF
if [ -z "$base" ] && [ -n "$GITHUB_BASE_REF" ]; then
  base=$(git merge-base "origin/$GITHUB_BASE_REF" HEAD) || {
    echo "::warning title=olp diff::the base is not there to compare with: check out with fetch-depth 0"
    base=none
  }
fi
if [ -n "$base" ] && [ "$base" != none ]; then
  olp diff "$base" . --format markdown -o "${OLP_COMMENT:-olp-diff.md}"
  status=$?
  # What could not be compared is a note here: olp check judges what is in the checkout.
  [ "$status" -ne 1 ] || [ "$worst" -ge 1 ] || worst=1
  [ -z "$GITHUB_STEP_SUMMARY" ] || [ ! -f "${OLP_COMMENT:-olp-diff.md}" ] ||
    cat "${OLP_COMMENT:-olp-diff.md}" >>"$GITHUB_STEP_SUMMARY"
fi
exit "$worst"
