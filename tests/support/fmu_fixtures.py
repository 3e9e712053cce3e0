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
FMI_ERRORS = fmpy.fmi1.FMICallException
DISCARD, ERROR = 2, 3


@pytest.fixture(params=VERSIONS)
def fmi(request):
    return request.param


def unpacked(path, folder):
    shutil.unpack_archive(path, folder, format="zip")
    return folder


@pytest.fixture(scope="session")
def fmus(two_mode_model, tmp_path_factory):
    """{2: path, 3: path}: contact motion and two DOFs, in a folder with an awkward name."""
    folder = tmp_path_factory.mktemp("with spaces, ünïcode %41 & more")
    options = {"contact": True, "elastic": (0, 1), "start": START}
    paths = {fmi: folder / f"Größe {fmi}.fmu" for fmi in VERSIONS}
    return {
        fmi: fmu.export(two_mode_model, paths[fmi], FORCE_PATTERNS, fmi=fmi, **options)
        for fmi in VERSIONS
    }


@pytest.fixture(scope="session")
def unzipped(fmus, tmp_path_factory):
    """{2: folder, 3: folder} with the contents of the FMUs; not to be changed."""
    folder = tmp_path_factory.mktemp("ünzipped %20 ")
    return {fmi: unpacked(path, folder / f"FMU {fmi}") for fmi, path in fmus.items()}


@pytest.fixture(scope="session")
def coulomb_model():
    reduced = rom.reduce(rom.two_mass())
    return rom.tabulate(reduced, rom.Coulomb(2.0), amplitude=(3.0, 3.0), tolerance=1e-2)


@pytest.fixture(scope="session")
def scalable(coulomb_model, tmp_path_factory):
    """{2: folder, 3: folder}: FMUs whose friction limit is an input, without contact motion."""
    folder, made = tmp_path_factory.mktemp("scalable"), {}
    for fmi in VERSIONS:
        path = folder / f"{fmi}.fmu"
        fmu.export(coulomb_model, path, FORCE_PATTERNS, fmi=fmi, start=START)
        made[fmi] = unpacked(path, folder / str(fmi))
    return made


def component(model, **options):
    """What the FMUs must agree with."""
    result = fmu.Component(model, FORCE_PATTERNS, contact=True, elastic=(0, 1), **options)
    result.set_inputs(**START)
    return result


# FMPy changes the working directory of the process while it loads a library.
LOADING = threading.Lock()


class Instance:
    """An instance behind names that both versions of the standard share.

    `messages` receives (status, text) of the log. `allowed`: further arguments of FMPy's
    `instantiate` in FMI 3.0.
    """

    def __init__(
        self, folder, fmi, exchange=False, token=None, name="test", messages=None, **allowed
    ):
        description = fmpy.read_model_description(folder)
        kinds = {2: (FMU2Slave, FMU2Model), 3: (FMU3Slave, FMU3Model)}
        self.fmi = fmi
        self.reference = {v.name: v.valueReference for v in description.modelVariables}
        self.messages = [] if messages is None else messages
        with LOADING:
            self.fmu = kinds[fmi][exchange](
                guid=token or description.guid,
                unzipDirectory=str(folder),
                modelIdentifier="slipmode",
                instanceName="test",
            )
        if fmi == 2:
            callbacks = fmi2CallbackFunctions()
            callbacks.logger = fmi2CallbackLoggerTYPE(
                lambda _, name, status, category, text: self._log(status, text)
            )
            self.fmu.instantiate(callbacks=callbacks)
        else:
            self.fmu.instantiate(
                logMessage=lambda _, status, category, text: self._log(status, text), **allowed
            )

    def _log(self, status, text):
        self.messages.append((status, text.decode()))

    def start(self, time=0.0, stop=None, **values):
        """Through initialization, with start values."""
        self.set(**values)
        if self.fmi == 2:
            self.fmu.setupExperiment(startTime=time, stopTime=stop)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=time, stopTime=stop)
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
        return self.fmu.doStep(time, duration)

    def refused(self, call, *arguments, **named):
        """Status and message of a call that is not OK."""
        with pytest.raises(FMI_ERRORS) as error:
            call(*arguments, **named)
        return error.value.status, self.messages[-1][1]

    def _state(self, call):
        """A function about states; its name differs in the versions."""
        return getattr(self.fmu, call if self.fmi == 2 else call.replace("FMUstate", "FMUState"))

    def serialize(self):
        state = self._state("getFMUstate")()
        data = self._state("serializeFMUstate")(state)
        self._state("freeFMUstate")(state)
        return data

    def restore(self, data):
        name = "deSerializeFMUstate" if self.fmi == 2 else "deserializeFMUState"
        state = getattr(self.fmu, name)(data)
        self._state("setFMUstate")(state)
        self._state("freeFMUstate")(state)

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


def not_made(folder, fmi, **options):
    """Texts that are logged where no instance is made."""
    messages = []
    with pytest.raises(Exception, match="Failed to instantiate"):
        Instance(folder, fmi, messages=messages, **options)
    assert {status for status, _ in messages} == {ERROR}
    return [text for _, text in messages]
