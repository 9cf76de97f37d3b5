import os
import pathlib
import subprocess
import sys

EXAMPLE = pathlib.Path(__file__).parents[2] / "examples/python_filter/my_filter.py"


def test_the_example_names_its_mistake(tmp_path):
    done = subprocess.run([sys.executable, EXAMPLE], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "Can this covariance be trusted? No: optimistic" in done.stdout
    assert "process noise Q assumed too small" in done.stdout
    assert os.path.exists(tmp_path / "out/index.html")
