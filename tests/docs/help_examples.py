"""Every example of `--help`, typed as it stands, in order, in an empty folder for each command. usage: help_examples.py PROGRAM [COMMAND...]

Left out are examples with a word in capitals, which stands for something of the user's, and commands that take minutes or that json_schemas.py
calls just so, unless they are named.
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile

# What needs more than the program: a queue of Slurm, a pager of manuals.
ELSEWHERE = re.compile(r" --submit$|\| man ")
SLOW = {"claims", "estimators", "selftest", "timing"}


def examples_of(text):
    found = re.search(r"^Examples:\n((?:  .*\n?)+)", text, flags=re.M)
    return [line.strip() for line in found.group(1).splitlines()] if found else []


def is_whole(example):
    return not re.search(r"(?<![\w-])[A-Z]{2,}|(?<![\w.])[AB]\.csv|\ba\.json b\.json", example.partition("    #")[0].replace("NEES", ""))


def main(program, *chosen):
    program = pathlib.Path(program).resolve()
    listed = subprocess.run([program, "--help"], capture_output=True, text=True, check=True).stdout
    commands = re.findall(r"^  ([a-z]+) {2,}", listed, flags=re.M)
    assert len(commands) > 20, commands
    failed, tried = 0, 0
    for command in chosen or [name for name in commands if name not in SLOW]:
        examples = examples_of(subprocess.run([program, command, "--help"], capture_output=True, text=True, check=True).stdout)
        if not examples:
            print(f"{command} --help has no examples")
            failed += 1
        with tempfile.TemporaryDirectory() as folder:
            environment = dict(os.environ, HOME=folder, PATH=f"{program.parent}:{os.environ['PATH']}")
            for example in examples:
                if not is_whole(example) or ELSEWHERE.search(example):
                    continue
                tried += 1
                done = subprocess.run(["bash", "-c", f"{example}\ncode=$?\nwait\nexit $code"], cwd=folder, env=environment,
                                      stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=300)
                if done.returncode != 0:
                    failed += 1
                    print(f"{example}: exit code {done.returncode}\n{done.stdout[-1000:]}")
    print(f"{tried} examples, {failed} of them fail")
    return 1 if failed or not tried else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
