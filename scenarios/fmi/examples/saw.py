"""A flying saw in a co-simulation: python3 saw.py saw.fmu

A conveyor starts, the saw couples, cuts, and returns for the next piece. Prints the cuts; with --csv each step as numbers of all
digits. The unit is written by: coaxle fmu slave scenarios/saws/cut-to-length.toml --out saw.fmu
"""

import shutil
import sys

import fmpy

STEP = 0.001
PIECE = 1000.0  # mm
CUTS = 3
START = 600  # steps: the conveyor has its velocity, with which a saw is planned


def conveyor(t):
    """Position, velocity and acceleration at a time: to 500 mm/s with 1000 mm/s², from 1000 mm before the first cut."""
    ramp = min(t, 0.5)
    position = -1000.0 + 500.0 * ramp * ramp + 500.0 * (t - ramp)
    return [position, 1000.0 * ramp, 1000.0 if t < 0.5 else 0.0]


def main(path, as_csv):
    description = fmpy.read_model_description(path)
    reference = {v.name: v.valueReference for v in description.modelVariables}
    folder = fmpy.extract(path)
    saw = fmpy.instantiate_fmu(folder, description, fmi_type="CoSimulation")
    master = [reference["master." + of] for of in ("position", "velocity", "acceleration")]
    sync = [reference["command.master_sync_position"]]
    inputs = [reference["command." + of] for of in ("execute", "release", "move_to_start")]
    outputs = [reference[of] for of in ("position", "velocity", "acceleration")]
    words = [reference["phase"], reference["state"]]
    saw.enterInitializationMode()
    saw.setFloat64(sync, [300.0])
    saw.exitInitializationMode()
    cuts, n, commands = 0, 0, [False, False, False]
    while cuts < CUTS and n < 20_000:
        if n == START:
            commands = [True, False, False]
        saw.setFloat64(master, conveyor(n * STEP))
        saw.setBoolean(inputs, commands)
        saw.doStep(n * STEP, STEP)
        n += 1
        position, velocity, acceleration = saw.getFloat64(outputs)
        phase, state = saw.getString(words)
        if as_csv:
            print(n, *(number.hex() for number in (position, velocity, acceleration)))
        if phase == "in-sync" and position > 300.0 and not commands[1]:
            cuts += 1
            if not as_csv:
                print(f"cut {cuts} at {conveyor((n - 1) * STEP)[0] - position:.3f} mm of the conveyor")
            commands = [False, True, False]
        elif commands[1] and state == "continuous-motion":
            commands = [False, False, True]
        elif commands[2] and state == "standstill":
            # On the way to the start the axis is in discrete motion, so it has arrived.
            saw.setFloat64(sync, [300.0 + cuts * PIECE])
            commands = [True, False, False]
    saw.terminate()
    saw.freeInstance()
    shutil.rmtree(folder)
    if cuts < CUTS:
        sys.exit(f"received {cuts} cuts in {n * STEP} s, expected {CUTS}")


if __name__ == "__main__":
    main(sys.argv[1], "--csv" in sys.argv[2:])
