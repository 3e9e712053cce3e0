"""From measured decays or sine tests to a law of the slow flow, with its uncertainty.

identification.py      identify(): what the other files are called by. Start here.
records/               measurements: reading, defects, the usable part of each record
first_look.py          Gaussian demodulation: frequency and damping against amplitude
slow_laws.py           laws: linear, power law, cross effects, quadratic coupling
decay_flow.py          decays by a law, and the sensor signals of these
fit.py                 the fit to the raw signals; scatter between records
uncertainty.py         intervals: scatter, laws that predict as well, misfit of the law
initial_amplitudes.py  amplitudes at the start of a record
prediction.py          decays from the first milliseconds of a record
selection.py           the choice of a law: quiet records predict loud ones
sine/                  identify_sine(): sine tests of one mode
contacts/              fit_contacts(): contact laws of a structure from backbones
loops/                 fit_loops(): contact laws from loops of force against displacement
models/                identified laws: backbones, and models that run
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
