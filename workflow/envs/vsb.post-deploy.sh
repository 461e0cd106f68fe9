#!/usr/bin/env bash
# Runs in the new conda environment, from the folder the workflow was started in: the repository.
set -euo pipefail
pip install --quiet -r requirements.lock
pip install --quiet --no-deps --no-build-isolation .
