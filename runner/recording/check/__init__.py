"""Whether a recording is sound, and what can be had of one that is not.

info.py reads what a file says of itself, doctor.py every byte of it, recover.py writes a sound
recording from whatever is whole.
"""
