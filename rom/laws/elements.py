"""Elastic contacts as the core reads them: elements with sliders and springs."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipmode.rom import kernel
from slipmode.rom.arrays import Floats, as_floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.representable import LARGEST, SMALLEST, fits
from slipmode.rom.short_repr import frozen

SLIDERS, FRICTIONAL = 0, 1  # sm_element_law


@frozen
class Elements:
    """Elements of the elastic contacts of one structure."""

    element: NDArray[np.void]  # (elements,), as `sm_element`: the law and DOFs of each contact
    slider: Floats  # (sliders, 2), limit [N] and stiffness [N/m] of each slider
    reference: Floats  # (N_c,), stiffness in stick [N/m]; 0 if the contact is open at rest

    @property
    def homogeneous(self) -> bool:
        """Whether limits and preloads times s make S(|a|; s) = s S(|a| / s; 1).

        Not without contacts, which have no limits.
        """
        return self.element.size > 0 and not self.element["gap"].any()

    @property
    def odd(self) -> bool:
        """Whether the opposite motion has the opposite force."""
        return bool(np.all(self.element["law"] == SLIDERS))

    @property
    def limit(self) -> Floats:
        """Friction limit of a contact at rest, and its normal force (N_c,) [N]."""
        limit = np.zeros(self.reference.size)
        for element in self.element:
            if element["law"] == SLIDERS:
                own = element["first_slider"] + np.arange(element["sliders"])
                limit[element["column"][0]] = self.slider[own, 0].sum()
            else:
                tangential, normal = np.split(element["column"][: element["tangents"] + 1], [-1])
                limit[tangential] = element["friction"] * element["preload"]
                limit[normal] = element["preload"]
        return limit

    @property
    def flexibility(self) -> Floats:
        """Diagonal matrix of 1 / reference (N_c, N_c) [m/N]; 0 for contacts open at rest."""
        k = self.reference
        return np.diag(np.divide(1.0, k, out=np.zeros_like(k), where=k > 0.0))

    def march(self, displacement: Floats, memory: Floats | None = None) -> tuple[Floats, Floats]:
        """Return the forces along displacements (n, N_c), and the memory at their end.

        The memory is the internal forces of the elements [N]. They begin at rest by default.
        """
        law, contacts = ctypes.byref(self.kernel()), displacement.shape[1]
        rest = np.zeros(int(kernel.lib.sm_elastic_memory(law)))
        memory = rest if memory is None else memory.copy()
        force = np.empty(displacement.shape)
        for x, f in zip(kernel.contiguous(displacement), force, strict=True):
            status = kernel.lib.sm_elastic_force(law, contacts, x, memory, f)
            kernel.check(status, "forces on the contacts")
        return force, memory

    def kernel(self) -> kernel.Structure:
        """Return the elements as the core reads them."""
        return kernel.Elastic(
            elements=len(self.element),
            sliders=len(self.slider),
            element=self.element,
            slider=self.slider,
            reference=self.reference,
        )


def sliders_on(limit: Floats, stiffness: Floats) -> Elements:
    """Return parallel Jenkins elements on each contact DOF; limit, stiffness (N_c, sliders)."""
    contacts, count = limit.shape
    element = np.zeros(contacts, dtype=kernel.ELEMENT)
    element["law"] = SLIDERS
    element["column"][:, 0] = np.arange(contacts)
    element["sliders"] = count
    element["first_slider"] = count * np.arange(contacts)
    slider = np.stack((limit, stiffness), axis=-1).reshape(-1, 2)
    return Elements(element, np.ascontiguousarray(slider), stiffness.sum(axis=1))


def joined(parts: Sequence[tuple[Elements, Sequence[int]]], contacts: int) -> Elements:
    """Return the elements of groups that are on different ones of `contacts` contact DOFs."""
    reference = np.zeros(contacts)
    moved, first = [], 0
    for part, columns in parts:
        numbers = np.asarray(columns, dtype=np.int32)
        element = part.element.copy()
        element["column"] = numbers[np.minimum(element["column"], numbers.size - 1)]
        element["first_slider"] += first
        reference[numbers] = part.reference
        moved.append(element)
        first += len(part.slider)
    sliders = np.concatenate([part.slider for part, _ in parts])
    return Elements(np.concatenate(moved), np.ascontiguousarray(sliders), reference)


def per_contact(name: str, value: ArrayLike, contacts: int) -> Floats:
    """Return a parameter of each contact from one number or one per contact."""
    given = as_floats(name, value)
    if given.ndim == 1 and given.size != contacts:
        raise SlipmodeError(
            f"{name}: must be one number or {contacts} numbers (one per contact), got {given.size}"
        )
    return np.full(contacts, given)


def checked(
    name: str, value: float | Sequence[float], unit: str, *, positive: bool = False
) -> float | tuple[float, ...]:
    """Return a parameter, checked, as hashable numbers; >= 0, or > 0 if `positive`."""
    given = as_floats(name, value)
    fine = given.ndim <= 1 and given.size > 0 and fits(given) and bool(np.all(given >= 0))
    if not fine or (positive and not given.all()):
        zero = "" if positive else "0 or "
        raise SlipmodeError(
            f"{name}: must be {zero}{SMALLEST:g} to {LARGEST:g} {unit}, got {value}"
        )
    return tuple(given.tolist()) if given.ndim else float(given)
