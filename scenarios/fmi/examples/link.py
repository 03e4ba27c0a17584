"""A link against the run of its scenario, digit for digit: python3 link.py link.fmu trace.csv [master.csv]

    coaxle run scenarios/fmi/examples/link.toml --trace csv --out run
    coaxle fmu link scenarios/fmi/examples/link.toml --out link.fmu
    python3 scenarios/fmi/examples/link.py link.fmu run/trace.csv

Without master.csv (position, velocity and acceleration, a row for each step) the master moves by the scenario.
"""

import csv
import math
import shutil
import sys

import fmpy

READ = {"Float64": float, "Int64": int, "UInt64": int, "Boolean": lambda text: text == "true", "String": str}
UNKNOWN = {"Float64": math.nan, "Int64": 0, "UInt64": 0, "Boolean": False, "String": ""}


def main(path, trace, master):
    description = fmpy.read_model_description(path)
    variables = {v.name: v for v in description.modelVariables}
    folder = fmpy.extract(path)
    link = fmpy.instantiate_fmu(folder, description, fmi_type="CoSimulation")
    step = float(description.coSimulation.fixedInternalStepSize)
    inputs = [variables["master." + of].valueReference for of in ("position", "velocity", "acceleration")]
    with open(trace, newline="") as file:
        run = {row["at_ns"]: row for row in csv.DictReader(file)}
    columns = [name for name in next(iter(run.values())) if name in variables]
    by_kind = {kind: [name for name in columns if str(variables[name].type) == kind] for kind in READ}
    motion = None
    if master is not None:
        with open(master, newline="") as file:
            motion = [[float(number) for number in row] for row in csv.reader(file)]
    link.enterInitializationMode()
    link.setBoolean([variables["master.from_scenario"].valueReference], [motion is None])
    link.exitInitializationMode()
    compared = 0
    for n in range(len(run) - 1 if motion is None else len(motion)):
        if motion is not None:
            link.setFloat64(inputs, motion[n])
        link.doStep(n * step, step)
        row = run.get(str(link.getInt64([variables["at_ns"].valueReference])[0]))
        if row is None:
            continue
        for kind, names in by_kind.items():
            values = getattr(link, "get" + kind)([variables[name].valueReference for name in names])
            for name, received in zip(names, values):
                expected = READ[kind](row[name]) if row[name] != "" else UNKNOWN[kind]
                both_unknown = received != received and expected != expected
                if received != expected and not both_unknown:
                    sys.exit(f"step {n}: {name} is {received!r}, expected {expected!r}")
        compared += 1
    link.terminate()
    link.freeInstance()
    shutil.rmtree(folder)
    print(f"{compared} cycles with {len(columns)} signals each: equal")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], sys.argv[3] if len(sys.argv) > 3 else None)
