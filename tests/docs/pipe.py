"""The filter of docs/formats.md, fed by `credence world`, has the numbers of the built-in one. usage: pipe.py PAGE PROGRAM"""

import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

SCENARIO = """
[world]
model = "linear"
F = [[1]]
G = [[1]]
H = [[1]]
Q = [[0.04]]
R = [[0.25]]
P0 = [[1]]
states = ["x"]
[study]
runs = 100
steps = 50
"""


def main(page, program):
    program = pathlib.Path(program).resolve()
    text = pathlib.Path(page).read_text()
    code = re.search(r"## A filter in any language.*?```python\n(.*?)```", text, re.S)[1]
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "one.toml").write_text(SCENARIO)
        (folder / "my_filter.py").write_text(code)
        pipe = f"'{program}' world one.toml | '{sys.executable}' my_filter.py | '{program}' check - --format json --quiet"
        piped = json.loads(subprocess.run(["bash", "-o", "pipefail", "-c", pipe], cwd=folder, check=True,
                                          capture_output=True).stdout)
        built_in = json.loads(subprocess.run([program, "run", "one.toml", "--format", "json", "--quiet"], cwd=folder,
                                             check=True, capture_output=True).stdout)
    assert piped["verdict"] == built_in["verdict"] == "consistent", (piped["verdict"], built_in["verdict"])
    for key in "nees", "nis":
        seen, wanted = piped[key]["mean"], built_in[key]["mean"]
        assert math.isclose(seen, wanted, rel_tol=1e-12), (key, seen, wanted)


if __name__ == "__main__":
    main(*sys.argv[1:])
