"""Several modes on a tone: K amplitudes under one force, with friction by contact.

    (2 i Omega + c_k) a_k' + sum_l D_kl a_l = F_k / 2 + sum_i conj(psi_ik) y_i

Contact i moves by x_i = sum_k psi_ik a_k + the response of all other modes, and has the force
deficit y_i(|x_i|) x_i / |x_i|. Close or equal frequencies need this: amplitudes of modes on one
tone act on each other through every contact. Steady states may have a second tone, under a force
of its own.

tone_states.py       steady states on one or two tones, transients on one. Start here.
tone_curve.py        steady states against the frequency
tone_response.py     linear response of a reduced structure with stuck contacts
tone_flow.py         the amplitudes in time, step by step
core_tone.py         the flow as the core reads it
tone_modes.py        poles and shapes of the amplitudes
contact_balance.py   steady states of the contacts by Newton's method
coupled_contacts.py  all contacts together, at the higher harmonics too
"""
