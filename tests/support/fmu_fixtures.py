"""FMUs of the two-mode model, and how the tests drive them."""

import shutil
import threading
from contextlib import contextmanager

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Model, FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Model, FMU3Slave

from slipmode import fmu, rom

FORCE_PATTERNS = ({0: 1.0}, {1: 1.0})
START = {"force_A": 0.15, "frequency_A": 0.98, "force_B": 0.25, "frequency_B": 1.65}
VERSIONS = (2, 3)


@pytest.fixture(scope="session")
def fmus(two_mode_model, tmp_path_factory):
    """{2: path, 3: path}: contact motion and two DOFs, in a folder with an awkward name."""
    folder = tmp_path_factory.mktemp("with spaces, ünïcode %41 & more")
    return {
        fmi: fmu.export(
            two_mode_model,
            folder / f"Größe {fmi}.fmu",
            FORCE_PATTERNS,
            fmi=fmi,
            contact=True,
            elastic=(0, 1),
            start=START,
        )
        for fmi in VERSIONS
    }


@pytest.fixture(scope="session")
def unzipped(fmus, tmp_path_factory):
    """{2: folder, 3: folder} with the contents of the FMUs; not to be changed."""
    folders = {}
    for fmi, path in fmus.items():
        folders[fmi] = tmp_path_factory.mktemp("ünzipped %20 ") / f"FMU {fmi}"
        shutil.unpack_archive(path, folders[fmi], format="zip")
    return folders


@pytest.fixture(scope="session")
def coulomb_model():
    reduced = rom.reduce(rom.two_mass())
    return rom.tabulate(reduced, rom.Coulomb(2.0), amplitude=(3.0, 3.0), tolerance=1e-2)


@pytest.fixture(scope="session")
def scalable(coulomb_model, tmp_path_factory):
    """{2: folder, 3: folder}: FMUs whose friction limit is an input, without contact motion."""
    folder = tmp_path_factory.mktemp("scalable")
    for fmi in VERSIONS:
        path = fmu.export(
            coulomb_model, folder / f"{fmi}.fmu", FORCE_PATTERNS, fmi=fmi, start=START
        )
        shutil.unpack_archive(path, folder / str(fmi), format="zip")
    return {fmi: folder / str(fmi) for fmi in VERSIONS}


def component(model, **options):
    """What the FMUs must agree with."""
    result = fmu.Component(model, FORCE_PATTERNS, contact=True, elastic=(0, 1), **options)
    result.set_inputs(**START)
    return result


# FMPy changes the working directory of the process while it loads a library.
LOADING = threading.Lock()


class Instance:
    """An instance behind names that both versions of the standard share."""

    def __init__(self, folder, fmi, exchange=False, token=None, name="test"):
        description = fmpy.read_model_description(folder)
        kinds = {2: (FMU2Slave, FMU2Model), 3: (FMU3Slave, FMU3Model)}
        self.fmi = fmi
        self.reference = {v.name: v.valueReference for v in description.modelVariables}
        self.messages = []
        with LOADING:
            self.fmu = kinds[fmi][exchange](
                guid=token or description.guid,
                unzipDirectory=str(folder),
                modelIdentifier="slipmode",
                instanceName=name,
            )
        self._instantiate()

    def _instantiate(self):
        def log2(environment, name, status, category, message):
            self.messages.append((status, message.decode()))

        def log3(environment, status, category, message):
            self.messages.append((status, message.decode()))

        if self.fmi == 2:
            callbacks = fmi2CallbackFunctions()
            callbacks.logger = fmi2CallbackLoggerTYPE(log2)
            self.fmu.instantiate(callbacks=callbacks)
        else:
            self.fmu.instantiate(logMessage=log3)

    def start(self, time=0.0, **values):
        """Through initialization, with start values."""
        self.set(**values)
        if self.fmi == 2:
            self.fmu.setupExperiment(startTime=time)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=time)
        self.fmu.exitInitializationMode()
        return self

    def set(self, **values):
        references = [self.reference[name] for name in values]
        setter = self.fmu.setReal if self.fmi == 2 else self.fmu.setFloat64
        if references:
            setter(references, list(values.values()))

    def get(self, *names):
        references = [self.reference[name] for name in names]
        getter = self.fmu.getReal if self.fmi == 2 else self.fmu.getFloat64
        return np.array(getter(references))

    def step(self, time, duration):
        self.fmu.doStep(time, duration)

    def serialize(self):
        if self.fmi == 2:
            state = self.fmu.getFMUstate()
            data = self.fmu.serializeFMUstate(state)
            self.fmu.freeFMUstate(state)
        else:
            state = self.fmu.getFMUState()
            data = self.fmu.serializeFMUState(state)
            self.fmu.freeFMUState(state)
        return data

    def restore(self, data):
        if self.fmi == 2:
            state = self.fmu.deSerializeFMUstate(data)
            self.fmu.setFMUstate(state)
            self.fmu.freeFMUstate(state)
        else:
            state = self.fmu.deserializeFMUState(data)
            self.fmu.setFMUState(state)
            self.fmu.freeFMUState(state)

    def free(self):
        self.fmu.freeInstance()


@contextmanager
def instance(folder, fmi, **options):
    """An instance that is freed at the end."""
    made = Instance(folder, fmi, **options)
    try:
        yield made
    finally:
        made.free()
