"""Mistakes of a master: each is an error with a sentence in the log, and none ends the process."""

import shutil
import sys

import fmpy
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

log = []


def note(_environment, status, category, message):
    assert (status, category) in ((3, b"logStatusError"), (1, b"logStatusWarning")), (status, category)
    log.append(message.decode())


def refused(call, expected):
    """Checks that a call fails, and that the log has this sentence."""
    log.clear()
    try:
        call()
    except Exception as error:
        assert any(expected in line for line in log), (expected, log, error)
        return
    sys.exit(f"received no error, expected one with {expected!r}")


def main(link, saw):
    for path in (link, saw):
        problems = validate_fmu(path)
        assert not problems, problems
    description = fmpy.read_model_description(saw)
    reference = {v.name: v.valueReference for v in description.modelVariables}
    folder = fmpy.extract(saw)

    def instance(token=None):
        unit = FMU3Slave(
            guid=token or description.instantiationToken,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="saw",
        )
        unit.instantiate(loggingOn=True, logMessage=note)
        return unit

    refused(lambda: instance("{another}"), "instantiationToken: received {another}, expected coaxle-slave-")
    unit = instance()
    position = [reference["master.position"]]
    refused(lambda: unit.setFloat64([999_999], [1.0]), "valueReference: received 999999, expected 0 to ")
    refused(lambda: unit.setFloat64(position, [float("nan")]), "master.position: received NaN, expected a finite number")
    refused(lambda: unit.setFloat64([reference["position"]], [1.0]), "expected a parameter or an input")
    refused(lambda: unit.getBoolean(position), "master.position: received Boolean, expected Float64")
    refused(lambda: unit.getFloat32(position), "fmi3GetFloat32: received 1 value references, expected none")
    refused(lambda: unit.enterEventMode(), "fmi3EnterEventMode: received a call")
    refused(lambda: unit.doStep(0.0, 0.001), "fmi3DoStep: received a call before initialization mode")
    unit.enterInitializationMode()
    unit.exitInitializationMode()
    refused(lambda: unit.doStep(0.0, 0.0), "communicationStepSize: received 0 s")
    refused(lambda: unit.doStep(0.0, -0.001), "communicationStepSize: received -0.001 s")
    refused(lambda: unit.doStep(0.0, 0.0015), "communicationStepSize: received 0.0015 s, expected a whole number of cycles of 0.001 s")
    unit.doStep(0.0, 0.001)
    refused(lambda: unit.doStep(0.0, 0.001), "currentCommunicationPoint: received 0 s, expected 0.001 s")

    def steps(first, number):
        for n in range(first, first + number):
            unit.setFloat64(position, [0.5 * n])
            unit.setFloat64([reference["master.velocity"]], [500.0])
            unit.setBoolean([reference["command.execute"]], [n > 100])
            unit.doStep(n * 0.001, 0.001)
        return unit.getFloat64([reference["position"], reference["velocity"]])

    steps(1, 199)
    state = unit.getFMUState()
    ahead = steps(200, 100)
    unit.setFMUState(state)
    assert steps(200, 100) == ahead
    serialized = unit.serializeFMUState(state)
    unit.freeFMUState(state)
    refused(lambda: unit.deserializeFMUState(serialized[:20]), "serializedState: received 20 bytes that are no state")
    unit.reset()
    unit.setFMUState(unit.deserializeFMUState(serialized))
    assert steps(200, 100) == ahead
    unit.terminate()
    unit.freeInstance()

    with open(f"{folder}/resources/cut-to-length.toml", "a") as file:
        file.write("nonsense = [\n")
    refused(instance, "instantiationToken: received coaxle-slave-")
    with open(f"{folder}/resources/unit.toml", "w") as file:
        file.write("kind = 'slave'\nmain = 'a.toml'\nfiles = ['../a.toml']\n")
    refused(instance, 'file: received "../a.toml", expected a path in the folder')
    shutil.rmtree(folder)
    print("each mistake has its sentence")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
