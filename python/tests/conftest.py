# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The program beside the module: what both say must be the same."""

import os
import pathlib
import subprocess

import pytest


@pytest.fixture(scope="session")
def program():
    """Runs `sightline` with arguments; returns its exit code, output and errors."""
    path = os.environ.get("SIGHTLINE_PROGRAM")
    if path is None:
        pytest.skip("SIGHTLINE_PROGRAM does not name the program")

    def run(*arguments):
        words = [path, *(str(argument) for argument in arguments)]
        return subprocess.run(words, capture_output=True, text=True, check=False)

    return run


@pytest.fixture
def here(tmp_path, monkeypatch) -> pathlib.Path:
    """A new working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path
