"""From matrices to modes and a contact problem of size N_c.

reduction.py          reduce: which modes, law, carriers and force patterns. Start here.
bonded.py, stuck.py   Eqs. (8), (13), (20): reduction about bonded or stuck contacts
reduced.py            Reduced, the result: Eq. (12) with damping and inertia of the contacts
nonlinear/            geometric nonlinearity: quadratic and cubic stiffness of the modes
nonresonant.py        other modes that respond to the contacts
reaction.py           force of the responding modes back on the contacts
interaction/          internal resonances, and modes that must be retained together
combination.py        harmonics n Omega_A + m Omega_B that come near a carrier
force_response.py     effects of the forces besides the excitation of their own mode
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
