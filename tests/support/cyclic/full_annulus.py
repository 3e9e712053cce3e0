"""Steady waves and waves from rest of all sectors, integrated in full: the reference."""

import numpy as np

from slipmode.rom import Contacts, full


def excitation(disk, structure, nodal_diameter, frequency, pattern):
    """Re(pattern exp(i (Omega t + k 2 pi j / N))) on sector j."""
    f = disk.around(np.asarray(pattern, dtype=complex), nodal_diameter)
    harmonic = full.Excitation.harmonic
    return harmonic(structure, (f.real, -f.imag), 2 * (frequency,), (0.0, -0.5 * np.pi))


def law_of_all(disk, law):
    size = disk.n_contacts
    return Contacts([(law, range(j * size, (j + 1) * size)) for j in range(disk.sectors)])


def steady_amplitude(disk, law, nodal_diameter, frequency, pattern):
    """Of all DOFs at the forcing frequency, (n_s N,), and the estimate of its error."""
    structure = disk.annulus()
    excited = excitation(disk, structure, nodal_diameter, frequency, pattern)
    outputs = range(structure.n_dofs)
    law = law_of_all(disk, law)
    found = full.steady_amplitude(structure, law, excited, outputs=outputs)
    # both carriers have the same frequency
    return found.amplitude[0], found.error.max()
