"""From matrices to modes and a contact problem of size N_c.

reduction.py          reduce: K_xx of Eq. (13), coupling of Eq. (20). Start here.
reduced.py            Reduced, what comes out: Eq. (12) with damping and inertia of the contacts
fixed_interface.py    Eq. (8): modes with bonded contacts
nonresonant.py        other modes that respond to the contacts; reaction.py: with which force
combination.py        harmonics n Omega_A + m Omega_B that come near a carrier
force_response.py     what forces do past their own mode; coupling.py: L_j(nu) off the carrier
stiffness_margin.py   how soft contacts are against the modes that respond to them
"""
