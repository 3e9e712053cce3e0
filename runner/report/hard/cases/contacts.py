"""Contacts: without friction, never slipping, very stiff, one and a hundred."""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial

import numpy as np

from slipmode import rom
from slipmode.runner.report.cases.cases import Case, two_mode
from slipmode.runner.report.hard.hard_case import SIGNAL, HardCase
from slipmode.runner.report.hard.signals import error_of, signal_error
from slipmode.runner.report.methods.ours import SlowCase

_STIFF = 1e6
_SOFT, _BAR = 0.25, 1e4  # stiffness between contacts, relative to what holds them
_TABLE_SECONDS = 30.0  # 100 contacts, one mode


def one_mass(contacts: int, joint: float = _SOFT) -> rom.Structure:
    """One mass on many contacts that share the stiffness of the paper's first; one mode.

    Each contact is joined to the next `joint` times as stiffly as it is held.
    """
    n = contacts + 1
    own, held = 1.0 / contacts, 20.0 / contacts
    between = joint * held
    mass = np.diag([1.0, *(contacts * [0.01 / contacts])])
    joined = 2.0 * np.eye(contacts) - np.eye(contacts, k=1) - np.eye(contacts, k=-1)
    joined[0, 0] = joined[-1, -1] = 1.0
    if contacts == 1:
        joined[:] = 0.0
    stiffness = np.zeros((n, n))
    stiffness[0, 0] = 1.0
    stiffness[0, 1:] = stiffness[1:, 0] = -own
    stiffness[1:, 1:] = (own + held) * np.eye(contacts) + between * joined
    return rom.Structure(mass, stiffness, 0.01, contact=range(1, n))


def many_contacts(contacts: int, joint: float = _SOFT) -> Case:
    """Limits from half to one and a half of their mean: contacts slip one after the other."""
    spread = np.linspace(0.5, 1.5, contacts) if contacts > 1 else np.ones(1)
    plural = "s" if contacts > 1 else ""
    return Case(
        f"{contacts} contact{plural}",
        one_mass(contacts, joint),
        rom.Coulomb((2.0 / contacts * spread).tolist()),
        force=({0: 0.15},),
        frequency=(0.98,),
        observed=(0,),
    )


@cache
def _hundred(joint: float) -> SlowCase:
    return SlowCase.tabulate(many_contacts(100, joint), 1e-3)


def _hundred_seconds(joint: float) -> float:
    return _hundred(joint).seconds


def _hundred_error() -> float:
    return error_of(_hundred(_SOFT))


def _with_law(name: str, law: rom.Friction) -> Case:
    return replace(two_mode(), name=name, law=law)


def _stiff(name: str, law: rom.Friction) -> Case:
    structure = rom.two_mass(beta=0.01, k_c1=20.0 * _STIFF, k_c2=40.0 * _STIFF)
    return replace(two_mode(), name=name, structure=structure, law=law)


def contact_cases() -> list[HardCase]:
    """Friction limits, stiffness and number of contacts."""
    slides, sticks = "a division by the limit", "contacts that never slip"
    stiff = "fast contact modes that a step does not resolve"
    bar = replace(many_contacts(30, _BAR), name="bar on 30 contacts")
    signals = [
        (_with_law("mu N = 0, tanh", rom.Tanh(0.0, 0.02)), slides),
        (_with_law("mu N = 0, Coulomb", rom.Coulomb(0.0)), slides),
        (_with_law("mu N = 1e9, tanh", rom.Tanh(1e9, 0.02)), sticks),
        (_with_law("mu N = 1e9, Coulomb", rom.Coulomb(1e9)), sticks),
        (_stiff("K_cc x 1e6, tanh", rom.Tanh(2.0, 0.02)), stiff),
        (_stiff("K_cc x 1e6, Coulomb", rom.Coulomb(2.0)), stiff),
        (many_contacts(1), "sizes taken for granted"),
        (bar, "contacts that slip all at once, each by the others' leave"),
    ]
    fast = ("mu N = 1e9, Coulomb", "K_cc x 1e6, Coulomb", "1 contact")
    found = [
        HardCase(
            case.name,
            risk,
            "RMS of displacements, 600 s from rest",
            SIGNAL,
            partial(signal_error, case),
            motion=case,
            slow=case.name not in fast,
        )
        for case, risk in signals
    ]
    return found + _hundred_contacts()


def _hundred_contacts() -> list[HardCase]:
    case = many_contacts(100)
    return [
        HardCase(
            case.name,
            "contacts that slip one after the other",
            "RMS of displacements, 600 s from rest",
            SIGNAL,
            _hundred_error,
            motion=case,
            slow=True,
        ),
        HardCase(
            "100 contacts, table",
            "work that grows with the cube of their number",
            "seconds for a one-mode table to 1e-3",
            _TABLE_SECONDS,
            partial(_hundred_seconds, _SOFT),
            slow=True,
        ),
        HardCase(
            "bar on 100 contacts, table",
            "contact steps that do not converge",
            "seconds for a one-mode table to 1e-3",
            _TABLE_SECONDS,
            partial(_hundred_seconds, _BAR),
            slow=True,
        ),
    ]
