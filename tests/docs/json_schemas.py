"""The JSON Schemas of docs/schemas against what the commands print, and that of the scenario against the scenarios.

usage: json_schemas.py CREDENCE           fails where a document does not satisfy its schema
       json_schemas.py CREDENCE --write   makes docs/schemas/*.json anew from the documents, but those BY_HAND

A schema has every key that all documents of a command have as required, and their types. A number may be null
everywhere (`null_reason`); keys that a schema does not have are allowed, since they may be added within a version.
"""

import collections
import copy
import json
import os
import pathlib
import random
import subprocess
import sys
import tempfile
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SCHEMAS = ROOT / "docs" / "schemas"
DRAFT = "https://json-schema.org/draft/2020-12/schema"

BY_NAME = {"blocks"}  # keys of objects whose own keys are names in the log
OF_WORLD = {"scenario"}  # whose own keys are those of a world: none is required

PREPARE = [  # commands that leave behind what others look at
    "run planar_loop --runs 20 --steps 40 --log logs --fresh",
    "run planar_loop --runs 20 --steps 40 --out run",
    "run figure1_two_landmarks --runs 40 --out other",
    "run tracking --runs 4 --steps 60 --log tracks --fresh",
    "sweep mistuned_sweep --runs 20 --steps 20 --out sweep",
]
DOCUMENTS = {
    "run": ["run planar_loop --runs 20 --steps 40", "run figure1_two_landmarks --runs 40", "run linear --runs 20 --steps 50",
            "run localisation --runs 4 --steps 300", "run missed_detections --runs 40",
            "run figure1_one_landmark figure3_one_landmark --runs 20", "run tracking_radar --runs 2 --steps 20",
            "run inertial --runs 4 --steps 20"],
    "check": ["check logs", "check logs --sensitivity --within 0.2", "check logs/run-000000.csv", "check tracks", "check plain.csv", "check right.csv", "check nis.csv", "check two.csv",
              "check one.csv", "check single.csv", "check blank.csv"],
    "sweep": ["sweep mistuned_sweep --runs 20 --steps 20",
              "sweep mistuned_sweep --runs 20 --steps 20 --shard 1/2 --out shard"],
    "estimators": ["estimators ukfm_slam2d --estimators ekf,fej --runs 10 --steps 60",
                   "estimators linear_estimators --runs 10 --steps 40",
                   "estimators linear_estimators --runs 4 --steps 20 --set noise.detection_probability=0.8",
                   "estimators zhang_3d --set world.landmarks=20 --runs 4 --steps 40",
                   "estimators linear_estimators --runs 8 --steps 20 --set sweep.filter.measurement_scale=1,4"],
    "tune": ["tune tracking --runs 10 --steps 40", "tune linear --runs 10 --steps 40", "tune tracks", "tune carpark --free noise.range_std"],
    "stability": ["stability figure2_two_landmarks", "stability figure3_one_landmark", "stability linear",
                  "stability linear --set world.F=[[3,0.01,0],[0,0.95,-0.5],[0,0,1]] --set world.H=[[0,1,0]]"],  # fails at a step
    "plan": ["plan figure1_two_landmarks --factor 1.2"],
    "compare": ["compare run other"],
    "show": ["show run", "show sweep"],
    "list": ["list"],
    "claims": ["claims"],
    "timing": ["timing --landmarks 10,20 --observed 1 --repetitions 1"],
    "selftest": ["selftest --studies 100"],
    "replay": ["replay carpark", "replay mrclam --robot 1"],
}
OF_DATA = ("carpark", "mrclam")  # in CREDENCE_DATA, without it left out
BY_HAND = {"estimators", "tune"}  # of several kinds of documents, each with members of its own


def known_documents():
    there = {name: [c for c in commands if "CREDENCE_DATA" in os.environ or c.split()[1:2] not in ([d] for d in OF_DATA)]
             for name, commands in DOCUMENTS.items()}
    return {name: commands for name, commands in there.items() if commands}


def run(credence, arguments, folder):
    told = subprocess.run([credence, *arguments.split()], cwd=folder, capture_output=True, text=True)
    if told.returncode not in (0,):
        raise SystemExit(f"credence {arguments} failed:\n{told.stderr}")
    return told.stdout


def write_logs(folder):
    """Logs of exact filters of two states and of innovations alone, as others than ours have them."""
    draw = random.Random(5).gauss

    def write(name, columns, rows, runs):
        lines = [",".join(["run", "step", *columns])]
        for run in range(runs):
            for step in range(1, rows + 1):
                lines.append(",".join([str(run), str(step), *("" if x is None else f"{x:.9g}" for x in (v() for v in columns.values()))]))
        (pathlib.Path(folder) / name).write_text("\n".join(lines) + "\n")

    def error():
        return draw(0.0, 1.0)

    def one():
        return 1.0

    def blank():
        return None

    def state(a, b):
        return {f"error.{a}": error, f"error.{b}": error, f"P.{a}.{a}": one, f"P.{a}.{b}": lambda: 0.0, f"P.{b}.{b}": one}

    gps = {"innovation.gps.1": error, "S.gps.1.1": one}
    write("plain.csv", state("x1", "x2"), 40, 30)
    write("right.csv", {**state("position", "velocity"), **gps}, 200, 1)
    write("nis.csv", {"nis.1": lambda: error() ** 2}, 60, 4)
    write("two.csv", {**gps, "innovation.imu.1": lambda: 2.0 * error(), "S.imu.1.1": one}, 60, 25)
    write("one.csv", state("x1", "x2"), 1, 1)
    write("single.csv", {"error.x": error, "P.x.x": one}, 40, 30)
    write("blank.csv", {**gps, "innovation.imu.1": blank, "S.imu.1.1": blank}, 60, 2)


def loosened(schema):
    schema = {k: v for k, v in schema.items() if k != "required"}
    if "properties" in schema:
        schema["properties"] = {k: loosened(v) for k, v in schema["properties"].items()}
    return schema


def member(key, value):
    if key in BY_NAME and isinstance(value, dict):
        inner = {}
        for of_name in value.values():
            inner = joined(inner, schema_of(of_name))
        return {"type": ["object"], "additionalProperties": inner}
    return loosened(schema_of(value)) if key in OF_WORLD else schema_of(value)


def schema_of(value):
    if isinstance(value, dict):
        return {"type": ["object"], "properties": {k: member(k, v) for k, v in value.items()}, "required": sorted(value)}
    if isinstance(value, list):
        items = {}
        for element in value:
            items = joined(items, schema_of(element))
        return {"type": ["array"], "items": items}
    if value is None:
        return {"type": ["null"]}
    if isinstance(value, bool):
        return {"type": ["boolean"]}
    if isinstance(value, str):
        return {"type": ["string"]}
    return {"type": ["number", "null"]} if isinstance(value, float) else {"type": ["integer", "null"]}


def joined(a, b):
    if not a or not b:
        return copy.deepcopy(a or b)
    types = sorted(set(a["type"]) | set(b["type"]))
    if "number" in types:
        types = [t for t in types if t != "integer"]
    schema = {"type": types}
    of = [s for s in (a, b) if "properties" in s]
    if of:
        keys = dict.fromkeys(key for s in of for key in s["properties"])
        schema["properties"] = {k: joined(*([s["properties"].get(k, {}) for s in of] + [{}])[:2]) for k in keys}
        if all("required" in s for s in of):
            schema["required"] = sorted(set.intersection(*(set(s["required"]) for s in of)))
    if any("additionalProperties" in s for s in (a, b)):
        schema["additionalProperties"] = joined(a.get("additionalProperties", {}), b.get("additionalProperties", {}))
    if "array" in types:
        schema["items"] = joined(a.get("items", {}), b.get("items", {}))
    return schema


def simplified(schema):
    """One type is no list, nothing required is not written. What was null in every document may be anything in others,
    and a reason is there only beside what is null."""
    schema = dict(schema)
    if schema.get("type") == ["null"]:
        return {}
    if len(schema.get("type", [])) == 1:
        schema["type"] = schema["type"][0]
    if "required" in schema:
        schema["required"] = [key for key in schema["required"] if key != "reason"]
    if not schema.get("required", True):
        del schema["required"]
    if "properties" in schema:
        schema["properties"] = {k: simplified(v) for k, v in schema["properties"].items()}
    for of in ("items", "additionalProperties"):
        if of in schema:
            schema[of] = simplified(schema[of])
    return schema


def shared(schema):
    """Objects that occur more than once become $defs, by the name of the key that they are first seen under."""
    seen, names = collections.Counter(), {}

    def visit(part, name, found):
        for key, inner in part.get("properties", {}).items():
            visit(inner, key, found)
        for of in ("items", "additionalProperties"):
            if of in part:
                visit(part[of], name, found)
        if "properties" in part:
            found(json.dumps(part, sort_keys=True), name)

    visit(schema, "", lambda text, name: seen.update([text]))

    def take(text, name):
        if seen[text] > 1 and text not in names:
            names[text] = next(n for n in (name, *(f"{name}_{i}" for i in range(2, 99))) if n not in names.values())

    visit(schema, "", take)

    def replaced(part, inside=None):
        text = json.dumps(part, sort_keys=True) if "properties" in part else None
        if text in names and text != inside:
            return {"$ref": f"#/$defs/{names[text]}"}
        part = dict(part)
        if "properties" in part:
            part["properties"] = {k: replaced(v) for k, v in part["properties"].items()}
        for of in ("items", "additionalProperties"):
            if of in part:
                part[of] = replaced(part[of])
        return part

    definitions = {name: replaced(json.loads(text), text) for text, name in names.items()}
    return {**replaced(schema), **({"$defs": definitions} if definitions else {})}


def pretty(value, indent=0):
    """JSON with what fits a line on one line."""
    text = json.dumps(value, ensure_ascii=False)
    if indent + len(text) <= 116 or not isinstance(value, dict):
        return text
    inner = [f'{" " * (indent + 1)}{json.dumps(k)}: {pretty(v, indent + 1)}' for k, v in value.items()]
    return "{\n" + ",\n".join(inner) + f'\n{" " * indent}}}'


def check_scenarios(credence, validator):
    schema = json.loads(subprocess.run([credence, "schema"], check=True, capture_output=True, text=True).stdout)
    validator.check_schema(schema)
    of_schema = validator(schema)
    for file in sorted((ROOT / "scenarios").glob("*.toml")):
        for error in of_schema.iter_errors(tomllib.loads(file.read_text())):
            yield f"{file.name}: {error.message}"
    for wrong in ('[world]\nmodel = "monobo"', '[world]\nmodel = "linear"\nF = [[1]]', '[world]\nmodel = "monobot"\nlandmarks = 2.5', "[study]\nruns = 10",
                  '[world]\nmodel = "monobot"\npath_radius = 3.0', '[world]\nmodel = "monobot"\n[nose]\nx = 1',
                  '[world]\nmodel = "monobot"\n[noise]\nprocess_variance = -0.1',
                  '[world]\nmodel = "monobot"\n[study.stop]\nprecison = 0.1'):
        if of_schema.is_valid(tomllib.loads(wrong)):
            yield f"accepted, and should not be: {wrong!r}"


def check_documents(validator, documents):
    for name, found in documents.items():
        schema = json.loads((SCHEMAS / f"{name}.json").read_text())
        validator.check_schema(schema)
        of_schema = validator(schema)
        for arguments, document in found:
            for error in of_schema.iter_errors(document):
                yield f"credence {arguments}: {error.json_path}: {error.message[:200]}"
        if of_schema.is_valid({}):
            yield f"{name}.json asks for nothing"


def main(credence, write=None):
    credence = str(pathlib.Path(credence).resolve())
    with tempfile.TemporaryDirectory() as folder:
        for arguments in PREPARE:
            run(credence, arguments, folder)
        write_logs(folder)
        documents = {name: [(c, json.loads(run(credence, f"{c} --format json", folder))) for c in commands]
                     for name, commands in known_documents().items()}
    if write == "--write":
        SCHEMAS.mkdir(exist_ok=True)
        for name, found in documents.items():
            if name in BY_HAND:
                continue
            schema = {}
            for _, document in found:
                schema = joined(schema, schema_of(document))
            schema = {"$schema": DRAFT, "title": f"What `credence {name} --format json` prints", **shared(simplified(schema))}
            (SCHEMAS / f"{name}.json").write_text(pretty(schema) + "\n")
        return 0
    try:
        from jsonschema import Draft202012Validator
    except ImportError:
        print("python3-jsonschema is not installed")
        return 77
    errors = [*check_scenarios(credence, Draft202012Validator), *check_documents(Draft202012Validator, documents)]
    print("\n".join(errors) or f"{sum(map(len, documents.values()))} documents and all scenarios satisfy their schemas")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]) if len(sys.argv) in (2, 3) else __doc__)
