"""The contact problem, Eq. (13): friction laws, periodic motion, harmonics."""
