#!/bin/sh
# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
#
# What a CI job does to guard a pipeline of one's own (docs/ci/): the pictures, the pipeline, the
# judgement, and the comparison with a run that was looked at. The last exit code is compare's: 0,
# or 3 where the pipeline has become worse.
#
#   guard.sh FOLDER BASELINE [option of pipeline.py...]
#
# Without a baseline in that place the run becomes it.
set -eu
here=$(dirname "$0")
sightline=${SIGHTLINE:-sightline}
folder=$1
baseline=$2
shift 2
mkdir -p "$folder"

[ -d "$folder/set" ] ||
  "$sightline" render cube --count 40 --seed 5 --quiet --out "$folder/set"
"${PYTHON:-python3}" "$here/pipeline.py" "$folder/set" "${SIGHTLINE_CUBE:-$here/../../assets/targets/cube/target.toml}" \
  --keypoints "$folder/keypoints.csv" --poses "$folder/poses.csv" "$@"
"$sightline" evaluate "$folder/set" --target cube --out "$folder/now" --quiet \
  --observations "corners=$folder/keypoints.csv" --estimates "opencv=$folder/poses.csv" \
  --solvers orpe_weighed,oracle

if [ ! -e "$baseline" ]; then
  cp -r "$folder/now" "$baseline"
  exit 0
fi
"$sightline" compare "$baseline" "$folder/now" --junit "$folder/compare.xml" \
  --markdown "$folder/compare.md"
