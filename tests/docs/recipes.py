"""Runs the commands of docs/recipes.md as they stand there. usage: recipes.py PAGE PROGRAM

A block ```sh is one recipe: its lines are run by bash, all of them in one empty folder; what stands behind "#> " must be in
what they print. Blocks marked ```sh slow are left out.
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile


def recipes(page):
    """Title, commands and expected words of every block."""
    title = ""
    for part in re.split(r"^(## [^\n]*|```sh(?: slow)?\n.*?^```)$", page.read_text(), flags=re.M | re.S):
        if part.startswith("## "):
            title = part[3:]
        elif part.startswith("```sh\n"):
            lines = part.splitlines()[1:-1]
            yield title, [x for x in lines if not x.startswith("#>")], [x[3:] for x in lines if x.startswith("#> ")]


def main(page, program):
    found = list(recipes(pathlib.Path(page)))
    assert len(found) >= 9, f"only {len(found)} recipes found"
    failed = 0
    environment = dict(os.environ, PATH=":".join([str(pathlib.Path(program).resolve().parent),
                                                    str(pathlib.Path(sys.executable).parent), os.environ["PATH"]]))
    for title, commands, expected in found:
        assert len(commands) <= 3, f"{title}: {len(commands)} commands"
        assert expected, f"{title}: nothing is expected"
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(["bash", "-c", "\n".join([*commands, "code=$?", "wait", "exit $code"])], cwd=folder, env=environment,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=300)
        missing = [words for words in expected if words not in done.stdout]
        if done.returncode != 0 or missing:
            failed += 1
            print(f"{title}: exit code {done.returncode}, without {missing}:\n{done.stdout}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
