"""Public calls on a core with sanitizers, which first makes each call with a number spoiled.

    python spoiled_calls.py CORE PUBLIC SEED [TIMES]

CORE is the shared library; PUBLIC names what is called. Each function of the core that it reaches
is first called TIMES times with one number, or one pointer, of its arguments spoiled. Then every
allocation fails in turn. Whatever the arguments, the call returns a status that there is. If it is
OK, no result is NaN or infinite. If not, the state is as before and no memory is left allocated.
At the end the functions that were called are printed.
"""

import ctypes
import sys
from collections import Counter
from functools import partial
from threading import RLock

import numpy as np

LOAD = ctypes.CDLL
ctypes.CDLL = lambda name, *more, **options: LOAD(  # the core with sanitizers instead
    sys.argv[1] if "_core" in str(name) else name, *more, **options
)

from stepping import HELD, component  # noqa: E402

from slipmode import rom  # noqa: E402
from slipmode.fmu import Component  # noqa: E402
from slipmode.rom import kernel  # noqa: E402

OK, NO_MEMORY = 0, 3
MOST = 2  # calls of a function that are spoiled
LARGEST = 30_000  # bytes of contact problems: of more points, they take long with sanitizers
NUMBERS = {
    "f": (np.nan, np.inf, -np.inf, -1.0, 0.0, 1e308),
    "i": (-1, 2**31 - 1, -(2**31)),
    "P": (0,),
}
KINDS = {ctypes.c_double: "f", ctypes.c_int32: "i", ctypes.c_void_p: "P"}
PREDICATES = ("sm_curve_passes", "sm_curve_is_stable")  # an answer instead of a status


def numbers_of(kind, start=0):
    """Yield places and kinds of the numbers in a type of C: f, i, or P for a pointer."""
    if hasattr(kind, "_fields_"):
        for name, field, *_ in kind._fields_:
            if name != "of":
                yield from numbers_of(field, start + getattr(kind, name).offset)
    elif hasattr(kind, "_length_"):
        for k in range(kind._length_):
            yield from numbers_of(kind._type_, start + k * ctypes.sizeof(kind._type_))
    elif kind in KINDS:
        yield start, KINDS[kind]


class Part:
    """An array or a structure that a call reads or writes, as bytes."""

    def __init__(self, value):
        self.bytes = np.frombuffer(value, np.uint8)
        is_array = isinstance(value, np.ndarray)
        self.results = is_array and value.dtype.kind in "fc"
        if self.results:
            kind = ctypes.c_double
        else:
            kind = np.ctypeslib.as_ctypes_type(value.dtype) if is_array else type(value)
        self.item, self.places = ctypes.sizeof(kind), list(numbers_of(kind))
        self.before = self.bytes.copy()

    def spoil(self, rng):
        """Spoil a number."""
        place, kind = self.places[rng.integers(len(self.places))]
        place += self.item * int(rng.integers(self.bytes.size // self.item))
        number = rng.choice(NUMBERS[kind])
        value = np.array([number], {"f": float, "i": np.int32, "P": np.uint64}[kind])
        self.bytes[place : place + value.itemsize] = value.view(np.uint8)

    def restore(self):
        self.bytes[:] = self.before


def parts_of(values):
    """Yield the parts that arguments lead to."""
    for value in values:
        if isinstance(value, np.ndarray) and value.size and value.flags.writeable:
            yield Part(value)
        elif hasattr(value, "owned"):
            yield Part(value)
            if not isinstance(value, kernel.Curve):  # what it is of, a callback alone knows
                yield from parts_of(value.owned.values())


class Spoiled:
    """The functions of the core, which are first called with a number spoiled."""

    def __init__(self, core, rng, times):
        self._core, self._rng, self._times = core, rng, times
        self._lock, self._count, self.spoiled = RLock(), Counter(), set()
        self._left, self._blocks = (
            ctypes.c_int.in_dll(core, name) for name in ("allocations_left", "blocks")
        )

    def __getattr__(self, name):
        return partial(self._call, name)

    def _call(self, name, *arguments):
        with self._lock:
            self._count[name] += 1
            function = getattr(self._core, name)
            if (
                self._count[name] <= MOST
                and function.restype is ctypes.c_int32
                and name not in PREDICATES
            ):
                self._spoil(name, function, arguments)
            return function(*arguments)

    def _spoil(self, name, function, arguments):
        parts, state = list(parts_of(arguments)), self._state(name, arguments)
        if "torus" in name and sum(part.bytes.size for part in parts) > LARGEST:
            return
        self.spoiled.add(name)
        values = [k for k, each in enumerate(arguments) if isinstance(each, float | np.ndarray)]
        for _ in range(self._times):
            given, spoiled = list(arguments), self._rng.integers(len(parts) + 1)
            if spoiled < len(parts):
                parts[spoiled].spoil(self._rng)
            elif values:
                k = values[self._rng.integers(len(values))]
                is_number = isinstance(arguments[k], float)
                given[k] = float(self._rng.choice(NUMBERS["f"])) if is_number else None
            self._check(name, function, given, parts, state)
        for allowed in range(100):
            self._left.value = allowed
            status = self._check(name, function, arguments, parts, state)
            self._left.value = -1
            if status != NO_MEMORY:
                break

    def _check(self, name, function, arguments, parts, state):
        """Make a call that may be refused; restore everything."""
        made, blocks = None, self._blocks.value
        before = [part.bytes.copy() for part in parts]
        if name.endswith("create"):
            made = ctypes.c_void_p()
            arguments = (*arguments[:-1], ctypes.byref(made))
        status = function(*arguments)
        kind = "_".join(name.split("_")[:2])
        assert self._core.sm_message(status) != self._core.sm_message(-1), f"{name}: {status}"
        if made is not None:
            assert bool(made.value) == (status == OK), name
            getattr(self._core, f"{kind}_free")(made)
        for part, was in zip(parts, before, strict=True):
            if status == OK and part.results:
                now = part.bytes.view(float)
                changed = part.bytes.reshape(-1, 8) != was.reshape(-1, 8)
                assert np.isfinite(now[changed.any(axis=1)]).all(), f"{name}: not finite"
            part.restore()
        if state is not None:
            if status != OK and not name.endswith(("run", "trace")):
                np.testing.assert_array_equal(self._state(name, arguments), state, name)
            assert getattr(self._core, f"{kind}_set_state")(arguments[0], state) == OK
        assert self._blocks.value == blocks, f"{name}: {self._blocks.value - blocks} blocks remain"
        return status

    def _state(self, name, arguments):
        """State of the object that a function has as its first argument, or None."""
        kind = "_".join(name.split("_")[:2])
        if kind not in ("sm_component", "sm_tone") or not isinstance(
            arguments[0], ctypes.c_void_p
        ):
            return None
        state = np.empty(getattr(self._core, f"{kind}_state_count")(arguments[0]))
        assert getattr(self._core, f"{kind}_get_state")(arguments[0], state) == OK
        return state


def step(component, **inputs):
    component.set_inputs(**inputs)
    component.do_step(0.0, 3.0)
    component.outputs()
    component.set_state(component.get_state())
    rows = np.zeros((2, len(component.input_names)))
    for k, name in enumerate(component.input_names):
        rows[:, k] = inputs.get(name, float(name == "limit_scale"))
    component.run([1.0, 2.0], rows)
    return rows


def moved(model, forces):
    """Fast motion, marched and by sums of harmonics, of amplitudes that grow."""
    ones = np.ones((1, model.modes))
    slow = rom.SlowTrajectory(
        time=np.array([0.0, 20.0]),
        amplitude=np.outer([0.5, 1.0], 0.5 * model.table.amplitude_range + 0j),
        angle=np.outer([0.0, 20.0], model.reduced.carrier),
        frequency=ones * model.reduced.carrier,
        frequency_rate=0.0 * ones,
        force=np.array([forces]) + 0j,
        force_rate=0j * ones,
    )
    times = np.linspace(15.0, 20.0, 5)
    rom.reconstruct(model, slow, times, spin_up=1.0)
    rom.sum_harmonics(model, slow, times)


def integrated(structure, law):
    once = {name: [[0.1, 0.2]] for name in rom.full.Excitation.__dataclass_fields__}
    patterns = np.eye(structure.n_dofs)[:2]
    excitation = rom.full.Excitation(**once | {"patterns": patterns, "start": [0.0]})
    rom.full.integrate(structure, law, excitation, [1.0, 2.0], steps_per_period=20)


def rigid(law):
    reduced = rom.reduce(rom.two_mass(beta=0.01), (0, 1))
    model = rom.tabulate(reduced, law, (2.0, 1.0), 0.1, harmonics=5)
    made = component(HELD, model, contact=True, elastic=(0, 1))
    list(made.trace([1.0, 2.0], step(made, **HELD)))
    made.reset(time=1.0)
    moved(model, (0.15, 0.25))
    alone = rom.tabulate(rom.reduce(rom.two_mass(beta=0.01), (0,)), law, (3.0,), 0.1)
    rom.response_curve(alone, (0.98,), ({0: 0.15},), "frequency", ((0.9,), (1.05,)))
    rom.backbone(alone)
    integrated(rom.two_mass(beta=0.01), law)


JENKINS = rom.Jenkins(limit=(0.4, 0.2), stiffness=(0.3, 0.2))
LIFT_OFF = rom.Contacts(
    [
        (rom.FrictionalContact(0.3, 0.0, 0.2, 0.3, gap=0.02), (0, 1)),
        (rom.FrictionalContact(0.4, 1.0, 0.2, 0.3, tangents=2), (2, 3, 4)),
        (rom.Sliders((0.02, 0.03), (0.1, 0.1)), (5,)),
    ]
)


def chain(law):
    """Six masses between walls."""
    K, contacts = 2.0 * np.eye(6) - np.eye(6, k=1) - np.eye(6, k=-1), 6 if law is LIFT_OFF else 2
    return rom.Structure(np.eye(6), K, 0.01, contact=np.eye(6)[:, :contacts])


def elastic(law):
    force = ({3: 0.1},)
    structure = chain(law)
    reduced = rom.reduce(structure, (0,), law=law, force_patterns=force)
    model = rom.tabulate(reduced, law, (2.0,), 0.1, harmonics=3)
    made = Component(model, force, contact=True, elastic=(0, 3))
    step(made, force_A=1.0, frequency_A=float(reduced.frequency[0]))
    moved(model, (0.05,))
    integrated(structure, law)
    rom.steady_state(reduced, law, (float(reduced.frequency[0]),), force)
    if law is LIFT_OFF:
        rom.preload(structure, law, {0: 0.1, 1: 0.1, 4: 0.2}, warned=False)


def shared_tone():
    reduced = rom.reduce(chain(JENKINS), (4, 5), law=JENKINS, tones=(0, 0))
    model = rom.tabulate(reduced, JENKINS)
    made = Component(model, [{3: 1.0}], contact=True, elastic=(0, 3), warned=False)
    step(made, force_A=0.1, frequency_A=1.9)


PUBLIC = {
    "tanh": partial(rigid, rom.Tanh(2.0, 0.02)),
    "Coulomb": partial(rigid, rom.Coulomb(2.0)),
    "Jenkins": partial(elastic, JENKINS),
    "lift-off": partial(elastic, LIFT_OFF),
    "tone": shared_tone,
}

if __name__ == "__main__":
    _, _, public, seed, times = sys.argv
    kernel.lib = Spoiled(kernel.lib, np.random.default_rng(int(seed)), int(times))
    PUBLIC[public]()
    print(*sorted(kernel.lib.spoiled))
