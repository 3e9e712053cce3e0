"""Slow time: amplitude equations (18), (19), their steady states, the fast motion with them."""
