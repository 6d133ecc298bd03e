"""An instance of an FMU of either version of FMI behind the same calls."""

import re

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Slave


def values(description, name):
    """The variable of a scalar channel or the three or four of a vector, as results.npz names it."""
    quoted = re.sub(r"^([^.]*[^A-Za-z0-9_.][^.]*)\.", r"'\1'.", name)
    found = [v for v in description.modelVariables if v.name == quoted]
    return found or [v for v in description.modelVariables if v.name.rpartition(".")[0] == quoted]


class Slave:
    """An instance of an FMU of either version behind the same calls; errors of the FMU are exceptions with its words."""

    def __init__(self, path, unzipped, token=None):
        self.description = fmpy.read_model_description(path)
        self.old = self.description.fmiVersion == "2.0"
        self.log = []
        self.names = {v.name: v.valueReference for v in self.description.modelVariables}
        kind = FMU2Slave if self.old else FMU3Slave
        self.fmu = kind(
            guid=token or self.description.guid,
            unzipDirectory=str(unzipped),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="test",
        )
        if self.old:
            self.callbacks = fmi2CallbackFunctions()
            self.callbacks.logger = fmi2CallbackLoggerTYPE(
                lambda _env, _name, _status, _category, message: self.log.append(message.decode())
            )
            self.fmu.instantiate(callbacks=self.callbacks)
        else:
            self.fmu.instantiate(logMessage=lambda _env, _status, _category, message: self.log.append(message.decode()))

    def call(self, work, *arguments):
        before = len(self.log)
        try:
            return work(*arguments)
        except Exception as error:
            raise RuntimeError("; ".join(self.log[before:])) from error

    def start(self, time=0.0, **parameters):
        for name, value in parameters.items():
            name = name.replace("__", ".")
            if isinstance(value, int):
                setter = self.fmu.setInteger if self.old else self.fmu.setInt64
                self.call(setter, [self.names[name]], [value])
            else:
                self.set(**{name: value})
        if self.old:
            self.call(self.fmu.setupExperiment, None, time)
            self.call(self.fmu.enterInitializationMode)
        else:
            self.call(self.fmu.enterInitializationMode, None, time)
        return self

    def go(self):
        self.call(self.fmu.exitInitializationMode)
        return self

    def set(self, **inputs):
        setter = self.fmu.setReal if self.old else self.fmu.setFloat64
        self.call(setter, [self.names[n] for n in inputs], list(inputs.values()))

    def get(self, *names):
        getter = self.fmu.getReal if self.old else self.fmu.getFloat64
        return np.array(self.call(getter, [self.names[n] for n in names]))

    def elements(self, name):
        """References of the elements of an array over stations, as FMI 2.0 lists them, or the one of the array."""
        if self.old:
            return [ref for other, ref in self.names.items() if re.fullmatch(re.escape(name) + r"\[\d+\]\.[wxyz]", other)]
        return [self.names[name]]

    def get_array(self, name, rows):
        """An array over stations - (rows, ..)."""
        columns = 4 if name.endswith("zeta") else 3
        if self.old:
            found = self.call(self.fmu.getReal, self.elements(name))
        else:
            found = self.call(self.fmu.getFloat64, self.elements(name), rows * columns)
        return np.reshape(found, (rows, columns))

    def set_array(self, name, values):
        setter = self.fmu.setReal if self.old else self.fmu.setFloat64
        self.call(setter, self.elements(name), [float(x) for x in np.ravel(values)])

    def outputs(self):
        return self.get(*(v.name for v in self.description.modelVariables if v.causality == "output"))

    def step(self, time, size):
        self.call(self.fmu.doStep, time, size)

    def save(self):
        return self.fmu.getFMUstate() if self.old else self.fmu.getFMUState()

    def load(self, state):
        self.call(self.fmu.setFMUstate if self.old else self.fmu.setFMUState, state)

    def to_bytes(self, state):
        return self.fmu.serializeFMUstate(state) if self.old else self.fmu.serializeFMUState(state)

    def from_bytes(self, data):
        # FMPy wants the exact number of bytes in either version.
        return self.call(self.fmu.deSerializeFMUstate if self.old else self.fmu.deserializeFMUState, data)

    def derivative(self, unknowns, knowns, seeds):
        """Of variables by name along changes of others."""
        of, by = ([self.names[n] for n in names] for names in (unknowns, knowns))
        if self.old:
            return np.array(self.call(self.fmu.getDirectionalDerivative, of, by, list(seeds)))
        return np.array(self.call(self.fmu.getDirectionalDerivative, of, by, list(seeds), len(of)))
