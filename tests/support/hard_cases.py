"""The error of slow time against full order, from rest."""

from benchmarks.measure import worst_rms
from slipmode.rom import full


def error_of(slow):
    """RMS of the displacements by a given model."""
    case, marcher = slow.case, slow.march(1.0)
    motion = marcher.motion(marcher(), case.times)
    exact = full.integrate(
        case.structure,
        case.law,
        case.excitation,
        case.times,
        outputs=case.observed,
        steps_per_period=512,
    )
    return worst_rms(marcher.elastic(motion), exact.displacement)
