"""What tests of the Python package share: the program, a store of a phantom, and a folder of their own."""

import os
import signal
import subprocess

import pytest

KILN = os.environ["KILN"]

# Scripts start commands in the background with SIGINT ignored; tests of Ctrl-C would then wait for ever.
signal.signal(signal.SIGINT, signal.default_int_handler)


def run_tool(*arguments, cwd):
    """Runs the program and returns its output. Fails the test if the program fails."""
    done = subprocess.run([KILN, *map(str, arguments)], cwd=cwd, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="session")
def head(tmp_path_factory):
    """A store of a head of 96 x 80 x 64 voxels, with three levels."""
    folder = tmp_path_factory.mktemp("head")
    run_tool("convert", "phantom:head:96x80x64", "head.kiln", "--brick-size", 32, cwd=folder)
    return folder / "head.kiln"


@pytest.fixture(autouse=True)
def in_own_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
