"""The names of the C++ interface, docs/cpp.md: those in namespace credence of the headers that are installed.

usage: cpp_interface.py [--write]   without: fails where the page does not say what the headers hold
"""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/cpp.md"
MOST_NAMES = 200
HEAD = """# The C++ interface

Every name of `credence/credence.h` that is to be relied on, by the header that has it. What these headers hold in
`credence::internal` may change at any time. How to use them: [a filter and a world of your own](plugin.md), [a planar SLAM
filter](own_filter.md). `tests/docs/cpp_interface.py --write` makes this page.
"""
# A comment, a literal, or a bracket or semicolon of the code.
TOKEN = re.compile(r'//[^\n]*|"(?:\\.|[^"\\\n])*"|(?<!\w)\'(?:\\.|[^\'\\\n])*\'|[{}()\[\];]')


def installed():
    """The headers that credence.h includes, in the order in which a reader of it meets them."""
    found = []

    def visit(header):
        if header in found or not (ROOT / header).exists():
            return
        found.append(header)
        for include in re.findall(r'^#include "([^"]+)"', (ROOT / header).read_text(), flags=re.M):
            visit(include)

    visit("credence/credence.h")
    return found


def bodies_of(header, namespace):
    pattern = rf"^namespace {namespace} \{{\n(.*?)^\}}  // namespace"
    return re.findall(pattern, (ROOT / header).read_text(), flags=re.S | re.M)


def declarations(body):
    """The declarations of a namespace, each with its comment: (comment, code up to its first brace or end)."""
    depth = start = 0
    head_end = None
    for token in TOKEN.finditer(body):
        c = token.group()
        if c in "{([":
            if depth == 0 and c == "{" and head_end is None:
                head_end = token.start()
            depth += 1
        elif c in "})]":
            depth -= 1
        if depth == 0 and (c == ";" or (c == "}" and not re.match(r"\s*([;,(.]|&&)", body[token.end() :]))):
            text = body[start : head_end if head_end is not None else token.start()]
            comment = " ".join(re.findall(r"///(?!<|\s*@)\s*(.*)", text))
            after = re.match(r"[ \t]*///<\s*(.*)", body[token.end() :])
            code = re.sub(r"//[^\n]*|^\s*#.*", " ", text, flags=re.M).strip()
            if head_end is not None or not re.fullmatch(r"(class|struct) \w+", code):  # a declaration of what comes later
                yield comment or (after.group(1) if after else ""), code
            start, head_end = token.end(), None


def without_template_head(code):
    while code.startswith("template"):
        depth, end = 0, code.index("<")
        for end in range(end, len(code)):
            depth += {"<": 1, ">": -1}.get(code[end], 0)
            if depth == 0:
                break
        code = code[end + 1 :].strip()
    return code


def name_of(code):
    code = without_template_head(" ".join(code.split()))
    code = re.sub(r"^requires .*?(?=\b(class|struct)\b)", "", code)
    if re.match(r"(extern|using namespace|friend|static_assert)\b|using internal::", code) or not code:
        return None
    declared = re.match(r"(?:class|struct|enum class|concept|using) (\w+)", code)
    if declared:
        return declared.group(1)
    plain = re.sub(r"<[^<>()]*>", "", re.sub(r"<[^<>()]*>", "", re.sub(r"<[^<>]*>", "", code)))
    called = re.match(r"[^(=]*?([\w:]+)\s*(?:\(|=|$)", plain)
    return None if called is None or "::" in called.group(1) else called.group(1)  # a member of a class template


def first_sentence(comment):
    return re.match(r".*?[.:](?=\s|$)|.*", comment).group().rstrip(".:;")


def lent_names():
    """What is internal and of the interface as well, by the using-declarations of credence.h."""
    return set(re.findall(r"internal::(\w+)", " ".join(bodies_of("credence/credence.h", "credence"))))


def interface():
    """{header: {name: first sentence}} of what is public, each name once."""
    found, seen, lent = {}, set(), lent_names()
    for header in installed():
        for namespace in ("credence", "credence::internal"):
            for body in bodies_of(header, namespace):
                for comment, code in declarations(body):
                    name = name_of(code)
                    if name is None or name in seen or (name in lent) != (namespace == "credence::internal"):
                        continue
                    seen.add(name)
                    found.setdefault(header, {})[name] = first_sentence(comment)
    return found


def hidden_types(found):
    """Public names that are types within the project as well, which code of credence::internal would take for them."""
    names = {name for names in found.values() for name in names} - lent_names()
    for folder in ("core", "montecarlo", "analysis", "datasets", "reports"):
        for file in sorted((ROOT / folder).rglob("*.h")):
            body = "\n".join(bodies_of(file, "credence::internal"))
            for name in re.findall(r"^(?:struct|class|enum class|using) (\w+)(?= *[:={]| final)", body, flags=re.M):
                if name in names:
                    yield f"{file.relative_to(ROOT)}: {name}"


def page(found):
    text = HEAD
    for header, names in sorted(found.items()):
        text += f"\n## [{header}](../{header})\n\n| name | |\n|---|---|\n"
        text += "".join(f"| `{name}` | {sentence.replace('|', '&#124;')} |\n" for name, sentence in names.items())
    return text


def main():
    found = interface()
    count = sum(map(len, found.values()))
    if count > MOST_NAMES:
        sys.exit(f"{count} public names, at most {MOST_NAMES} are allowed: put what is internal into credence::internal")
    if hidden := list(hidden_types(found)):
        sys.exit("names of the interface, used for something internal: " + ", ".join(hidden))
    if blank := [name for names in found.values() for name, sentence in names.items() if not sentence]:
        sys.exit("names of the interface without a sentence: " + ", ".join(blank))
    if sys.argv[1:] == ["--write"]:
        PAGE.write_text(page(found))
    elif not PAGE.exists() or PAGE.read_text() != page(found):
        sys.exit("docs/cpp.md is not what the headers say: tests/docs/cpp_interface.py --write")
    print(f"{count} names in {len(found)} of {len(installed())} installed headers")


main()
