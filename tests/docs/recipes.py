"""Runs the commands of docs/recipes.md or docs/tutorials.md as they stand there. usage: recipes.py PAGE PROGRAM [MOST]

The blocks ```sh below one "## title" are run by bash in a folder that is empty for the first; what stands behind "#> " must
be in what a block prints, and a title has at most MOST commands, if that is given. Blocks marked ```sh slow are left out.
"""

import itertools
import os
import pathlib
import re
import subprocess
import sys
import tempfile


def blocks(page):
    """Title, commands and expected words of every block."""
    title = ""
    for part in re.split(r"^(## [^\n]*|```sh(?: slow)?\n.*?^```)$", page.read_text(), flags=re.M | re.S):
        if part.startswith("## "):
            title = part[3:]
        elif part.startswith("```sh\n"):
            lines = part.splitlines()[1:-1]
            yield title, [x for x in lines if not x.startswith("#>")], [x[3:] for x in lines if x.startswith("#> ")]


def main(page, program, most=None):
    found = [(title, list(of_title)) for title, of_title in itertools.groupby(blocks(pathlib.Path(page)), key=lambda block: block[0])]
    assert len(found) >= 3, f"only {len(found)} titles with commands found"
    failed = 0
    environment = dict(os.environ, PATH=":".join([str(pathlib.Path(program).resolve().parent),
                                                    str(pathlib.Path(sys.executable).parent), os.environ["PATH"]]))
    for title, of_title in found:
        assert most is None or sum(len(commands) for _, commands, _ in of_title) <= int(most), f"{title}: more than {most} commands"
        with tempfile.TemporaryDirectory() as folder:
            for _, commands, expected in of_title:
                assert expected, f"{title}: nothing is expected"
                done = subprocess.run(["bash", "-c", "\n".join([*commands, "code=$?", "wait", "exit $code"])], cwd=folder,
                                      env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=300)
                missing = [words for words in expected if words not in done.stdout]
                if done.returncode != 0 or missing:
                    failed += 1
                    print(f"{title}: exit code {done.returncode}, without {missing}:\n{done.stdout}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
