"""The JSON Schemas of docs/schemas against what the commands print, and that of the scenario against the scenarios.

usage: json_schemas.py CREDENCE           fails where a document does not satisfy its schema
       json_schemas.py CREDENCE --write   makes docs/schemas/*.json anew from DOCUMENTS; needs CREDENCE_DATA

A schema has every key that all documents of a kind have as required, and their types. A number may be null
everywhere (`null_reason`); keys that a schema does not have are allowed, since they may be added within a version.
OTHERS are documents that no schema is made from: what they lack must not be required.
"""

import collections
import concurrent.futures
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

BY_NAME = {"blocks", "part_factors", "unit_factors", "tuned_on_the_others"}  # keys of objects whose own keys are names
BY_SETTING = {"swept", "values", "settings"}  # likewise keys of a scenario, of values of any kind
OF_WORLD = {"scenario"}  # whose own keys are those of a world: none is required
SOMETIMES = {  # keys that are there where there is something to tell, as a `reason` is; no battery after an interruption
    "first_time_s", "last_time_s", "failed_at_step", "failure", "doubt", "most", "battery"}
NULLABLE = {  # keys of what may be null by docs/formats.md, beside numbers
    "bounded", "predicted_bounded", "paper_condition_holds", "depends", "white", "decided_by", "responsible_block",
    "optimistic_steps", "pessimistic_steps", "noise_condition", "calibration", "single_run", "time_offset", "units",
    "compared_by", "paired_difference", "reason", "gain", "swept", "long_run", "cheapest", "quantiles", "held_out",
    "log_score", "comes_first"}
NUMBERS = {"value", "lower", "upper"}  # also where every document has null
# Objects that are alike in all documents, by a key that tells them: what is null in one of them may be so in all.
EVERYWHERE = {"decided_by": "verdict", "second_moments": "battery", "joined": "word"}

# Documents of one command that have members of their own, each by a key at the top: the first one that is there.
KINDS = {
    "run": {"several": "studies", "one_run": "landmark_positions", "study": "nees"},
    "check": {"contents": "logs", "judgement": "nees"},
    "sweep": {"shard": "shard", "ranks": "rank_map", "sweep": "configurations"},
    "estimators": {"map": "points", "table": "rows"},
    "tune": {"of_logs": "sensors", "of_data": "left_out_by_gate", "of_scenario": "scenario"},
    "stability": {"table": "configurations", "planar": "filters", "linear": "long_horizon"},
    "plan": {"sweep": "sweep", "study": "nees"},
    "replay": {"variants": "variants", "several": "runs", "one": "nis"},
}
# Documents of one kind within those of another.
WITHIN = {"several of run": (["studies"], "study"), "map of estimators": (["points", "study"], "table")}

PREPARE = [  # commands that leave behind what others look at
    "run planar_loop --runs 20 --steps 40 --log logs --fresh",
    "run planar_loop --runs 20 --steps 40 --out run",
    "run figure1_two_landmarks --runs 40 --out other",
    "run tracking --runs 4 --steps 60 --log tracks --fresh",
    "sweep mistuned_sweep --runs 20 --steps 20 --out sweep",
    "check tracks --format json > tracks.json",
]
# S is 0 at the first step.
FAIL = "--runs 3 --steps 2 --set noise.measurement_variance=0 --set noise.process_variance=0 --set noise.initial_variance=0"
RANKS = "--runs 4 --steps 20 --set sweep.world.landmarks=1:2 --set sweep.filter.inflation_rank=0:2 --set sweep.study.seed=1"
DOCUMENTS = {
    "run": ["run planar_loop --runs 20 --steps 40", "run figure1_two_landmarks --runs 40", "run linear --runs 20 --steps 50",
            "run localisation --runs 4 --steps 300", "run missed_detections --runs 40",
            "run figure1_one_landmark planar_loop --runs 20 --steps 10", "run tracking_radar --runs 2 --steps 20",
            "run inertial --runs 4 --steps 20", "run figure1_two_landmarks --runs 8 --steps 10 --set noise.detection_probability=0.6",
            "run figure1_two_landmarks " + FAIL, "run linear --runs 1 --steps 20",
            "run linear --runs 20 --steps 20 --set study.stop.verdict=either",
            "run figure1_two_landmarks --runs 4 --steps 10 --only-run 0", "run tracking --runs 4 --steps 10 --only-run 1"],
    "check": ["check logs", "check logs --sensitivity --within 0.2", "check logs/run-000000.csv", "check tracks",
              "check plain.csv", "check right.csv", "check nis.csv", "check two.csv", "check one.csv", "check single.csv",
              "check blank.csv", "check wrong.csv", "check failed.csv", "check tracks --baseline tracks.json",
              "check logs --baseline tracks.json", "check --list logs"],
    "sweep": ["sweep mistuned_sweep --runs 20 --steps 20", "sweep figure1_two_landmarks " + FAIL,
              "sweep missed_detections --runs 4 --steps 10", "sweep map_solutions --runs 2 --steps 10", "sweep rank_map " + RANKS,
              "sweep mistuned_sweep --runs 20 --steps 20 --shard 1/2 --out shard"],
    "estimators": ["estimators ukfm_slam2d --estimators ekf,fej --runs 10 --steps 60",
                   "estimators linear_estimators --runs 10 --steps 40",
                   "estimators linear_estimators --runs 4 --steps 20 --set noise.detection_probability=0.8",
                   "estimators zhang_3d --set world.landmarks=20 --runs 4 --steps 40",
                   "estimators linear_estimators --runs 8 --steps 20 --set sweep.filter.measurement_scale=1,4"],
    "tune": ["tune tracking --runs 10 --steps 40", "tune linear --runs 10 --steps 40", "tune tracks", "tune two.csv",
             "tune linear --runs 5 --steps 20 --free Q",  # which cannot be told
             "tune carpark --free noise.range_std"],
    "stability": ["stability figure2_two_landmarks", "stability figure3_one_landmark", "stability linear",
                  "stability linear --set world.F=[[3,0.01,0],[0,0.95,-0.5],[0,0,1]] --set world.H=[[0,1,0]]",  # fails at a step
                  "stability figure1_one_landmark --set filter.inflation=rank --set filter.inflation_rank=1",
                  "stability planar_stability --loops 4", "stability planar_loop --loops 4",
                  "stability planar_loop --loops 4 --set noise.range_std=1e-9",  # fails
                  "stability map_solutions --loops 4 --set sweep.filter.solution=pairwise,sequential"],
    "plan": ["plan figure1_two_landmarks --factor 1.2", "plan mistuned_sweep --set sweep.filter.measurement_scale=1,2"],
    "compare": ["compare run other"],
    "list": ["list"],
    "claims": ["claims"],
    "timing": ["timing --landmarks 10,20 --observed 1 --repetitions 1"],
    "selftest": ["selftest --studies 100"],
    "replay": ["replay carpark", "replay mrclam --robot 1", "replay mrclam --robot 1,3", "replay carpark --variants"],
}
OTHERS = {
    "run": ["run zhang_3d --runs 2 --steps 20 --set world.landmarks=20", "run pendulum --runs 3 --steps 20", "run planar_loop --runs 1 --steps 10",
            "run planar_loop --runs 2 --steps 10 --only-run 0", "run figure3_one_landmark linear --runs 1 --steps 10",
            "run figure1_two_landmarks --runs 40 --set study.stop.precision=0.2", "run figure1_one_landmark " + FAIL],
    "sweep": ["sweep linear --runs 2 --steps 10 --set sweep.filter.process_scale=1,2", "sweep planar_table --runs 2 --steps 5",
              "sweep inertial --runs 2 --steps 5 --set sweep.world.dt=0.1,0.2", "sweep figure1_one_landmark --runs 4"],
    "check": ["check --pool tracks/run-000000.csv tracks/run-000001.csv", "check --list plain.csv"],
    "estimators": ["estimators ukfm_slam2d --estimators ekf --runs 2 --steps 20"],
    "tune": ["tune figure1_two_landmarks --runs 10 --steps 40", "tune logs", "tune right.csv"],
    "stability": ["stability tracking", "stability planar_table --loops 4 --set sweep.filter.inflation=map",
                  "stability figure1_two_landmarks --set filter.inflation=full", "stability figure2_two_landmarks --steps 1"],
    "plan": ["plan planar_loop", "plan linear --set sweep.filter.process_scale=1,2"],
    "compare": ["compare run run", "compare sweep sweep"],
    "show": ["show run", "show sweep"],
}
OF_DATA = ("carpark", "mrclam")  # in CREDENCE_DATA, without it left out


def known(commands):
    """Those whose data are here."""
    return [c for c in commands if os.environ.get("CREDENCE_DATA") or not of_data(c)]


def of_data(command):
    return any(word in OF_DATA for word in command.split())


def run(credence, arguments, folder):
    """What the command prints; runs that fail are no less a document."""
    arguments, _, file = arguments.partition(" > ")
    # Of the claims those of the data take the longest, and are told as the others are.
    environment = {k: v for k, v in os.environ.items() if k != "CREDENCE_DATA" or of_data(arguments)}
    told = subprocess.run([credence, *arguments.split()], cwd=folder, capture_output=True, text=True, env=environment)
    if told.returncode not in (0, 3):
        raise SystemExit(f"credence {arguments} failed:\n{told.stderr}")
    if file:
        (pathlib.Path(folder) / file).write_text(told.stdout)
    return told.stdout


def made(credence, commands, folder):
    """By the name of each command its documents, each with the arguments that give it."""
    listed = [(name, c) for name, of_name in commands.items() for c in known(of_name)]
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        told = list(pool.map(lambda of: json.loads(run(credence, f"{of[1]} --format json", folder)), listed))
    documents = collections.defaultdict(list)
    for (name, arguments), document in zip(listed, told):
        documents[name].append((arguments, document))
    return documents


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
    write("wrong.csv", {**state("x1", "x2"), "error.x1": lambda: 3.0 * error(), **gps}, 40, 30)
    write("failed.csv", {**state("x1", "x2"), **gps}, 40, 1)
    with (pathlib.Path(folder) / "failed.csv").open("a") as log:
        log.write("# failed: diverged at step 41\n")


def is_sometimes(key):
    return key in SOMETIMES or (key.endswith("reason") and key != "null_reason")


def loosened(schema):
    schema = {k: v for k, v in schema.items() if k != "required"}
    if "properties" in schema:
        schema["properties"] = {k: loosened(v) for k, v in schema["properties"].items()}
    return schema


class Schemas:
    """Those of values; of objects that are alike EVERYWHERE only the name, as `is`, and apart what all have that were seen."""

    def __init__(self):
        self.everywhere = {}

    def of(self, value, key=None):
        schema = self.of_value(value, key)
        return joined(schema, {"type": ["null"]}) if key in NULLABLE else schema

    def of_value(self, value, key):
        if isinstance(value, dict):
            return self.of_object(value, key)
        if isinstance(value, list):
            items = {}
            for element in value:
                items = joined(items, self.of(element))
            return {"type": ["array"], "items": items}
        if isinstance(value, float) or (value is None and key in NUMBERS):
            return {"type": ["null", "number"]}
        if value is None:
            return {"type": ["null"]}
        if isinstance(value, bool):
            return {"type": ["boolean"]}
        return {"type": ["string"]} if isinstance(value, str) else {"type": ["integer", "null"]}

    def of_object(self, value, key):
        if key in BY_SETTING:
            return {"type": ["object"]}
        if key in BY_NAME:
            inner = {}
            for of_name in value.values():
                inner = joined(inner, self.of(of_name))
            return {"type": ["object"], "additionalProperties": inner}
        schema = {"type": ["object"], "properties": {k: self.of(v, k) for k, v in value.items()}, "required": sorted(value)}
        name = key if key in OF_WORLD else next((name for told_by, name in EVERYWHERE.items() if told_by in value), None)
        if not name:
            return schema
        self.everywhere[name] = joined(self.everywhere.get(name, {}), loosened(schema) if name in OF_WORLD else schema)
        return {"type": ["object"], "is": name}

    def simplified(self, schema):
        """One type is no list, nothing required is not written. What was null in every document may be anything in others,
        and a reason is there only beside what is null."""
        if "is" in schema:
            schema = {**self.everywhere[schema["is"]], "type": schema["type"]}
        schema = dict(schema)
        if schema.get("type") == ["null"]:
            return {}
        if len(schema.get("type", [])) == 1:
            schema["type"] = schema["type"][0]
        if "required" in schema:
            schema["required"] = [k for k in schema["required"] if not is_sometimes(k)]
        if not schema.get("required", True):
            del schema["required"]
        if "properties" in schema:
            schema["properties"] = {k: self.simplified(v) for k, v in schema["properties"].items()}
        for of in ("items", "additionalProperties"):
            if of in schema:
                schema[of] = self.simplified(schema[of])
        return schema


def joined(a, b):
    if not a or not b:
        return copy.deepcopy(a or b)
    types = sorted(set(a["type"]) | set(b["type"]))
    if "number" in types:
        types = [t for t in types if t != "integer"]
    schema = {"type": types}
    if "is" in a or "is" in b:
        schema["is"] = a.get("is") or b["is"]
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


def kind_of(name, document):
    return next(kind for kind, key in KINDS[name].items() if key in document)


def documents_within(document, path):
    if isinstance(document, list):
        return [inner for each in document for inner in documents_within(each, path)]
    return documents_within(document[path[0]], path[1:]) if path else [document]


def put_within(schema, path, inner):
    if "items" in schema:
        return {**schema, "items": put_within(schema["items"], path, inner)}
    if not path:
        return inner
    return {**schema, "properties": {**schema["properties"], path[0]: put_within(schema["properties"][path[0]], path[1:], inner)}}


def by_kind(name, documents):
    """Those of each kind; one that lies within another is of its kind no less."""
    if name not in KINDS:
        return {name: documents}
    kinds = {kind: [] for kind in KINDS[name]}
    for document in documents:
        kind = kind_of(name, document)
        kinds[kind].append(document)
        path, inner = WITHIN.get(f"{kind} of {name}", ([], None))
        if inner:
            kinds[inner] += documents_within(document, path)
    return kinds


def of_kinds(name, kinds):
    """The schema of what is of one of these kinds, which are $defs by their names."""
    if name not in KINDS:
        return shared(kinds[name], {})
    for kind in kinds:
        path, inner = WITHIN.get(f"{kind} of {name}", ([], None))
        if inner:
            kinds[kind] = put_within(kinds[kind], path, kinds[inner])
    return shared({"anyOf": list(kinds.values())}, {json.dumps(of, sort_keys=True): kind for kind, of in kinds.items()})


def shared(schema, names):
    """Objects that occur more than once become $defs, by the name of the key that they are first seen under; `names`
    has those that are named already, by their text."""
    seen, parts = collections.Counter(), {}

    def inner_parts(part, name):
        yield from ((inner, key) for key, inner in part.get("properties", {}).items())
        yield from ((inner, name) for inner in part.get("anyOf", []))
        yield from ((part[of], name) for of in ("items", "additionalProperties") if of in part)

    def visit(part, name, found):
        for inner, key in inner_parts(part, name):
            visit(inner, key, found)
        if "properties" in part:
            text = json.dumps(part, sort_keys=True)
            parts.setdefault(text, part)
            found(text, name)

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
        if "anyOf" in part:
            part["anyOf"] = [replaced(each) for each in part["anyOf"]]
        for of in ("items", "additionalProperties"):
            if of in part:
                part[of] = replaced(part[of])
        return part

    definitions = {name: replaced(parts[text], text) for text, name in names.items()}
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


def schema_for(credence, name):
    """Of the file; one that refers to others is as the command prints it, with these inside."""
    schema = json.loads((SCHEMAS / f"{name}.json").read_text())
    if not any(part.get("$ref", "").endswith(".json") for part in schema.get("anyOf", [])):
        return schema
    return json.loads(subprocess.run([credence, "schema", name], check=True, capture_output=True, text=True).stdout)


def check_documents(credence, validator, documents):
    from jsonschema.exceptions import best_match

    for name, found in documents.items():
        schema = schema_for(credence, name)
        validator.check_schema(schema)
        of_schema = validator(schema)
        for arguments, document in found:
            error = best_match(of_schema.iter_errors(document))
            if error:
                yield f"credence {arguments}: {error.json_path}: {error.message[-200:]}"
        if of_schema.is_valid({}):
            yield f"{name}.json asks for nothing"


def write_schemas(documents):
    SCHEMAS.mkdir(exist_ok=True)
    schemas = Schemas()
    seen = {}
    for name, found in documents.items():
        for kind, of_kind in by_kind(name, [document for _, document in found]).items():
            for document in of_kind:
                seen[name, kind] = joined(seen.get((name, kind), {}), schemas.of(document))
    for name in documents:
        schema = of_kinds(name, {kind: schemas.simplified(of) for (of_name, kind), of in seen.items() if of_name == name})
        schema = {"$schema": DRAFT, "title": f"What `credence {name} --format json` prints", **schema}
        (SCHEMAS / f"{name}.json").write_text(pretty(schema) + "\n")


def main(credence, write=None):
    credence = str(pathlib.Path(credence).resolve())
    if write and not os.environ.get("CREDENCE_DATA"):
        raise SystemExit("--write needs CREDENCE_DATA, of which some documents are")
    with tempfile.TemporaryDirectory() as folder:
        write_logs(folder)
        for arguments in PREPARE:
            run(credence, arguments, folder)
        if write:
            write_schemas(made(credence, DOCUMENTS, folder))
            return 0
        commands = {name: DOCUMENTS.get(name, []) + OTHERS.get(name, []) for name in {**DOCUMENTS, **OTHERS}}
        documents = made(credence, commands, folder)
    try:
        from jsonschema import Draft202012Validator
    except ImportError:
        print("python3-jsonschema is not installed")
        return 77
    errors = [*check_scenarios(credence, Draft202012Validator), *check_documents(credence, Draft202012Validator, documents)]
    print("\n".join(errors) or f"{sum(map(len, documents.values()))} documents and all scenarios satisfy their schemas")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]) if len(sys.argv) in (2, 3) else __doc__)
