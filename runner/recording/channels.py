"""Recorded channels: their fields, their units, and the protobuf layout of their samples.

A sample is a flat protobuf message of doubles, all of them present. Each field has the same place
in every message, so a numpy structured array has the bytes of a whole batch. The protobuf package
is imported for schemas and events: scenes and plans need the names of channels only.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import Level, SlipmodeError
from slipmode.rom.laws.states import STATES

if TYPE_CHECKING:
    from google.protobuf.descriptor_pb2 import FileDescriptorSet

Mode = Literal["A", "B"]
MODES: tuple[Mode, ...] = ("A", "B")

EVENTS = "/events"
FULL = "/full"  # prefix of the topics of full-order motion
PHASES, TORUS = "/phases", "/torus"
SHARE = "/contact_share"
DISK, BLADES = "/disk", "/blades"
OTHER = "/other"  # prefix of the topics of other programs, which may equal ours

BAND = (5, 95)  # percentiles of the amplitudes of the samples of a model

NANOSECONDS = 1_000_000_000  # in a second
# By their numbers in foxglove.Log.Level
_LEVELS: dict[int, Level] = {2: "info", 3: "warning", 4: "error"}


@dataclass(frozen=True)
class Field:
    """One recorded quantity: its name within the channel and its physical unit."""

    name: str
    unit: str


@dataclass(frozen=True)
class Event:
    """What happened at a simulation time, in one line for the reader."""

    time: float  # [s]
    level: Level
    message: str


@dataclass(frozen=True)
class Channel:
    """Fields that are sampled together."""

    topic: str  # Name of the channel, "/modes" or "/contact/0"
    fields: tuple[Field, ...]  # Columns of every batch of this channel
    description: str  # Contents, for a reader of the file
    # Name of the messages, if the fields do not follow from the topic
    kind: str = field(default="", compare=False)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the fields, in column order."""
        return tuple(field.name for field in self.fields)

    @property
    def units(self) -> dict[str, str]:
        """Unit of each field, by its name."""
        return {field.name: field.unit for field in self.fields}

    @property
    def message_type(self) -> str:
        """Full name of the protobuf message, ``slipmode.Contact`` for ``/contact/0``."""
        return f"slipmode.{self.kind or self.topic.split('/')[1].capitalize()}"

    def descriptor(self) -> FileDescriptorSet:
        """Return the protobuf schema of a sample: field number j + 1 is column j."""
        from google.protobuf.descriptor_pb2 import (
            FieldDescriptorProto,
            FileDescriptorProto,
            FileDescriptorSet,
        )

        package, _, name = self.message_type.partition(".")
        file = FileDescriptorProto(name=f"{package}/{name}.proto", package=package)
        file.syntax = "proto3"
        message = file.message_type.add(name=name)
        kind, label = FieldDescriptorProto.TYPE_DOUBLE, FieldDescriptorProto.LABEL_OPTIONAL
        for number, name in enumerate(self.names, start=1):
            message.field.add(name=name, number=number, type=kind, label=label)
        return FileDescriptorSet(file=[file])

    def encode(self, values: Floats) -> NDArray[np.void]:
        """Return the protobuf messages of samples (n, n_fields), shape (n,)."""
        empty = self._empty_message
        size = np.dtype(f"V{empty.nbytes}")  # copied as a whole, not double by double
        wire = np.full(len(values), empty.view(size)).view(empty.dtype)
        for number, column in enumerate(values.T):
            wire[f"value {number}"] = column
        return wire

    def decode(self, messages: NDArray[np.void]) -> Floats:
        """Return the values (n, n_fields) of protobuf messages (n,); the inverse of `encode`.

        Raises SlipmodeError if a message has another layout than `encode` writes.
        """
        empty = self._empty_message
        if messages.dtype.itemsize != empty.nbytes:
            raise SlipmodeError(f"{self.topic}: the length of a sample does not fit its fields")
        wire = messages.view(empty.dtype)
        values = np.empty((len(messages), len(self.fields)))
        for number in range(len(self.fields)):
            values[:, number] = wire[f"value {number}"]
            if np.any(wire[f"tag {number}"] != empty[f"tag {number}"]):
                raise SlipmodeError(f"{self.topic}: the fields of a sample do not fit its schema")
        return values

    @cached_property
    def _empty_message(self) -> NDArray[np.void]:
        """A message of zeros, shape (): in front of each double the tag that names it."""
        tags = [_tag(number) for number in range(1, len(self.fields) + 1)]
        layout: list[tuple[str, str]] = []
        for number, tag in enumerate(tags):
            layout += [(f"tag {number}", f"S{len(tag)}"), (f"value {number}", "<f8")]
        data = b"".join(tag + bytes(8) for tag in tags)
        return np.frombuffer(data, np.dtype(layout)).reshape(())


def _fields(units: Mapping[str, str]) -> tuple[Field, ...]:
    return tuple(Field(name, unit) for name, unit in units.items())


def modes(present: Sequence[str] = ("A", "B"), band: bool = False) -> Channel:
    """Return the channel of slow complex modal amplitudes: x_e = 2 Re(phi a e^{i theta}).

    With a `band`, the moduli have percentiles of the samples of the model.
    """
    names = [f"{mode}_{part}" for mode in present for part in ("re", "im")]
    names += [f"{mode}_abs" for mode in present]
    names += [f"{mode}_abs_{percent}" for mode in present for percent in BAND if band]
    fields = _fields(dict.fromkeys(names, "kg^0.5 m"))
    return Channel("/modes", fields, "Slow complex modal amplitudes and their moduli")


class Moved(NamedTuple):
    """What a mode moves: the DOF that it moves most, and the contacts."""

    shape: float  # Mode shape at the DOF [kg^-1/2]
    dof: int
    contacts: float  # Largest displacement of a contact per amplitude [kg^-1/2]
    amplitude: float  # Largest expected amplitude [kg^1/2 m]; 0 if it is not known

    def describe(self) -> str:
        """Return what `parse` reads, for the metadata of a run."""
        words = f"{self.shape:.6g} kg^-0.5 at DOF {self.dof}, {self.contacts:.6g} at contacts"
        return f"{words}, amplitudes to {self.amplitude:.6g}" if self.amplitude else words

    @classmethod
    def parse(cls, text: str) -> Moved | None:
        """Return the inverse of `describe`; None of another text."""
        form = r"(\S+) kg\^-0.5 at DOF (\d+), (\S+) at contacts(?:, amplitudes to (\S+))?"
        if (found := re.fullmatch(form, text)) is None:
            return None
        shape, dof, contacts, amplitude = found.groups("0")
        return cls(float(shape), int(dof), float(contacts), float(amplitude))


def forcing(present: Sequence[str] = ("A", "B")) -> Channel:
    """Return the channel of force amplitude, frequency and phase of each mode."""
    units = {"force": "N", "frequency": "rad/s", "phase": "rad"}
    named = {f"{mode}_{name}": unit for mode in present for name, unit in units.items()}
    return Channel("/forcing", _fields(named), "Harmonic forcing near each resonance")


def contact(index: int, prefix: str = "") -> Channel:
    """Return the channel of displacement, velocity and friction force of a contact DOF."""
    fields = _fields({"x": "m", "v": "m/s", "f": "N"})
    return Channel(f"{prefix}/contact/{index}", fields, f"Motion of contact {index}")


def elastic_contact(index: int, tangents: int, prefix: str = "") -> Channel:
    """Return the channel of the motion, forces and state of elastic contact number `index`.

    x, v, f along its tangent; y, v_y, f_y along a second tangent; x_n, v_n along its normal,
    positive when closing; normal force N with preload; gap; state 0 stuck, 1 slipping, 2 open. A
    law without a normal has 0 `tangents`.
    """
    rigid, named = contact(index, prefix), dict[str, str]()
    if tangents == 2:
        named |= {"y": "m", "v_y": "m/s", "f_y": "N"}
    if tangents:
        named |= {"x_n": "m", "v_n": "m/s", "N": "N", "gap": "m"}
    fields = (*rigid.fields, *_fields(named), Field("state", "1"))
    words = f"{rigid.description}; state: 0 stuck, 1 slipping, 2 open"
    kind = ("ElasticContact", "FrictionalContact", "FrictionalContact2d")[tangents]
    return Channel(rigid.topic, fields, words, kind)


def contact_share(contacts: int) -> Channel:
    """Return the channel of the shares of a window, by its end, of each contact in each state."""
    fields = tuple(Field(f"contact_{i}_{name}", "1") for i in range(contacts) for name in STATES)
    return Channel(SHARE, fields, "Part of a window that each contact is stuck, slipping, open")


def phases() -> Channel:
    """Return the channel of the carrier angles at the samples of contact motion."""
    fields = _fields({"A_phase": "rad", "B_phase": "rad"})
    return Channel(PHASES, fields, "Phases of both carriers at the samples of contact motion")


def torus() -> Channel:
    """Return the channel of the motion of contact 0 over both phases, at a window's end."""
    words = "Motion of contact 0 over both phases, with the amplitudes at the end of a window"
    return Channel(TORUS, (*phases().fields, *contact(0).fields), words)


def elastic(dofs: Sequence[int]) -> Channel:
    """Return the channel of reconstructed displacements of elastic DOFs."""
    fields = tuple(Field(f"x_{dof}", "m") for dof in dofs)
    return Channel("/elastic", fields, "Reconstructed displacement of elastic DOFs")


def disk(sectors: int, dof: int) -> Channel:
    """Return the channel of a DOF in every sector, and of the state of its first contact."""
    names = dict.fromkeys((f"x_{j}" for j in range(sectors)), "m")
    names |= dict.fromkeys((f"state_{j}" for j in range(sectors)), "1")
    words = f"Displacement of DOF {dof} in every sector; state of its first contact: 0 stuck, "
    return Channel(DISK, _fields(names), f"{words}1 slipping, 2 open")


def blades(sectors: int, dof: int) -> Channel:
    """Return the channel of the amplitude of a DOF of every blade of a mistuned disk."""
    fields = _fields({f"blade_{j}_amplitude": "m" for j in range(sectors)})
    return Channel(BLADES, fields, f"Amplitude of DOF {dof} of every blade")


def energy() -> Channel:
    """Return the channel of the energy balance.

    The input power is the sum of the powers that contacts dissipate, that structural damping
    dissipates, and that the modes store.
    """
    units = {"input_power": "W", "dissipated_power": "W", "dissipated_energy": "J"}
    units |= {"structural_power": "W", "stored_power": "W"}
    words = "input_power = dissipated_power (contacts) + structural_power + stored_power"
    return Channel("/energy", _fields(units), f"{words}, averaged over the fast cycles")


def control() -> Channel:
    """Return the channel of friction limits relative to the model's."""
    return Channel("/control", (Field("limit_scale", "1"),), "Friction limits that change")


def event_descriptor() -> FileDescriptorSet:
    """Return the protobuf schema of an event: ``foxglove.Log``, which viewers show as text."""
    from google.protobuf import timestamp_pb2
    from google.protobuf.descriptor_pb2 import (
        FieldDescriptorProto,
        FileDescriptorProto,
        FileDescriptorSet,
    )

    log = FileDescriptorProto(name="foxglove/Log.proto", package="foxglove", syntax="proto3")
    log.dependency.append("google/protobuf/timestamp.proto")
    message = log.message_type.add(name="Log")
    levels = message.enum_type.add(name="Level")
    for number, name in enumerate(("UNKNOWN", "DEBUG", "INFO", "WARNING", "ERROR", "FATAL")):
        levels.value.add(name=name, number=number)
    kind = FieldDescriptorProto
    types = {"timestamp": kind.TYPE_MESSAGE, "level": kind.TYPE_ENUM, "line": kind.TYPE_FIXED32}
    type_names = {"timestamp": ".google.protobuf.Timestamp", "level": ".foxglove.Log.Level"}
    names = ("timestamp", "level", "message", "name", "file", "line")
    for number, name in enumerate(names, start=1):
        member = message.field.add(name=name, number=number, label=kind.LABEL_OPTIONAL)
        member.type = types.get(name, kind.TYPE_STRING)
        if name in type_names:
            member.type_name = type_names[name]
    timestamp = FileDescriptorProto()
    timestamp_pb2.DESCRIPTOR.CopyToProto(timestamp)
    return FileDescriptorSet(file=[timestamp, log])


def encode_event(event: Event, time_ns: int) -> bytes:
    """Return the protobuf message of an event; `time_ns` is its time in nanoseconds."""
    (level,) = (number for number, name in _LEVELS.items() if name == event.level)
    message = _log_message()(level=level, message=event.message, name="slipmode")
    message.timestamp.seconds, message.timestamp.nanos = divmod(time_ns, NANOSECONDS)
    return bytes(message.SerializeToString())


def decode_event(data: bytes, time_ns: int) -> Event:
    """Return the event of a protobuf message logged at `time_ns`; see `encode_event`."""
    message = _log_message().FromString(data)
    return Event(time_ns / NANOSECONDS, _LEVELS[message.level], message.message)


@cache
def _log_message() -> type[Any]:
    """Return the Python class of an event's message, from the schema in the file."""
    from google.protobuf import descriptor_pool, message_factory

    pool = descriptor_pool.DescriptorPool()
    for file in event_descriptor().file:
        pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName("foxglove.Log"))


def _tag(number: int) -> bytes:
    """Return the protobuf tag of a double: one byte up to field 15, two up to field 2047."""
    key = number << 3 | 1  # the wire type of a double
    return bytes([key] if key < 0x80 else [key & 0x7F | 0x80, key >> 7])
