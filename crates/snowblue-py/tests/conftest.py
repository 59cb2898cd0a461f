"""The command, whose figures the package must give too, and the code in the documents."""

import csv
import os
import re
import subprocess
from pathlib import Path

import matplotlib
import mitsuba
import pytest

matplotlib.use("Agg")
# The plug-ins are imported with the doctests.
mitsuba.set_variant(f"{os.environ.get('SNOWBLUE_MITSUBA', 'llvm')}_ad_rgb")

REPOSITORY = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def repository():
    return REPOSITORY


@pytest.fixture(scope="session")
def command():
    """Runs the command that the environment variable SNOWBLUE names, and gives what it prints as rows of a CSV."""
    program = os.environ["SNOWBLUE"]

    def run(*arguments):
        words = [program, *map(str, arguments), "--quiet", "--format", "csv"]
        done = subprocess.run(words, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return list(csv.DictReader(done.stdout.splitlines()))

    return run


@pytest.fixture(scope="session")
def blocks():
    """The blocks of Python in a document, in which texts are replaced by others, for less work to do."""

    def read(name, smaller=()):
        text = (REPOSITORY / name).read_text()
        for words, fewer in smaller:
            assert words in text, f"{name} has no {words!r}"
            text = text.replace(words, fewer)
        return re.findall(r"```python\n(.*?)```", text, re.DOTALL)

    return read
