"""Stages the pages of the documentation site: docs/*.md, the README, and what the program says of itself.

usage: stage.py CREDENCE PAGES    the program; the folder that mkdocs.yml takes its pages from, made anew

Pages: those of docs/; index.md (the README); commands.md and glossary.md, which the program prints; gallery.md, whose
commands are run. A link to a file that is no page leads to a copy of it, one to a folder becomes its name.
"""

import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
LINK = re.compile(r"\[([^\]]*)\]\(([^)#\s]+)(#[^)\s]*)?\)")


def output(credence, *arguments):
    return subprocess.run([credence, *arguments], check=True, capture_output=True, text=True).stdout


def page_of(source):
    """Where a page of the project lies in the site; None for other files."""
    if source == ROOT / "README.md":
        return pathlib.Path("index.md")
    if source.parent in (ROOT / "docs", ROOT) and source.suffix == ".md":
        return pathlib.Path(source.name)
    return None


def relinked(text, source, pages):
    def link(match):
        words, target, anchor = match[1], match[2], match[3] or ""
        if re.match(r"[a-z]+:", target):
            return match[0]
        file = (source.parent / target).resolve()
        page = page_of(file)
        if page is None and file.is_dir():
            return f"`{file.relative_to(ROOT)}`"
        if page is None:
            shown = str(file.relative_to(ROOT))
            page = pathlib.Path("files") / (shown if file.suffix == ".svg" else shown + ".txt")
            (pages / page).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, pages / page)
        return f"[{words}]({page}{anchor})"

    return LINK.sub(link, text)


def commands_page(credence):
    names = re.findall(r"^  ([a-z]+) {3,}\S", output(credence, "--help"), re.M)
    parts = ["# Commands", "As `credence help COMMAND` prints them."]
    parts += [f"## {name}\n\n```text\n{output(credence, 'help', name)}```" for name in names]
    return "\n\n".join(parts) + "\n"


def glossary_page(credence):
    words = [line[:18].strip() for line in output(credence, "explain").splitlines()]
    parts = ["# Glossary", "As `credence explain WORD` prints it."]
    parts += [f"## {word}\n\n{output(credence, 'explain', word)}" for word in words]
    return "\n\n".join(parts)


def run_example(credence, example, folder):
    arguments = shlex.split(example["command"])
    told = subprocess.run([credence, *arguments, "--out", folder, "--quiet"], capture_output=True, text=True)
    if told.returncode != 0:
        raise SystemExit(f"credence {example['command']} failed:\n{told.stderr}")
    return next(line for line in told.stdout.splitlines() if line.strip())


def gallery_page(credence, pages):
    examples = tomllib.loads((ROOT / "docs/site/gallery.toml").read_text())["example"]
    (pages / "gallery").mkdir()
    parts = ["# Gallery", "Each picture is a figure of the report that its command makes, and the sentence above it the "
             "answer it prints.\nThe scenarios come with the program."]
    with tempfile.TemporaryDirectory() as out:
        for i, example in enumerate(examples):
            folder = pathlib.Path(out) / str(i)
            answer = run_example(credence, example, folder)
            picture = pages / "gallery" / f"{i}.svg"
            shutil.copyfile(folder / "figures" / example["figure"], picture)
            scenario = shlex.split(example["command"])[1]
            parts += [f"## {example['title']}", f"`credence {example['command']}` says: *{answer}*",
                      example["learned"].strip(), f"![{example['title']}](gallery/{i}.svg)",
                      f'??? note "{scenario}.toml"\n\n    ```toml\n'
                      + "".join(f"    {line}\n" for line in
                                (ROOT / "scenarios" / f"{scenario}.toml").read_text().splitlines()) + "    ```"]
    return "\n\n".join(parts) + "\n"


def main(credence, pages):
    credence, pages = os.path.abspath(credence), pathlib.Path(pages)
    shutil.rmtree(pages, ignore_errors=True)
    pages.mkdir(parents=True)
    for source in [ROOT / "README.md", ROOT / "CHANGELOG.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").glob("*.md")]:
        (pages / page_of(source)).write_text(relinked(source.read_text(), source, pages))
    (pages / "commands.md").write_text(commands_page(credence))
    (pages / "glossary.md").write_text(glossary_page(credence))
    (pages / "gallery.md").write_text(gallery_page(credence, pages))


if __name__ == "__main__":
    main(*sys.argv[1:]) if len(sys.argv) == 3 else sys.exit(__doc__)
