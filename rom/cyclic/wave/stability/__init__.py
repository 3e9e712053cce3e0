"""Which waves grow, and to which amplitude.

flutter_growth.py   growth rates of all nodal diameters while the contacts stick. Start here
pair_stability.py   whether waves break into pairs of other nodal diameters
"""
