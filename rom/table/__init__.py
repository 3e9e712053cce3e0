"""Friction tables S_j = Q_j |a_j|, Eq. (20), over the amplitude plane; the model that holds them.

tabulation.py        tabulate: resolution, refinement, check, corrections. Start here.
candidates.py        modes and harmonics that a table may have
hermite.py           Table: the bicubic surface; the look-up is rom/kernel/table/table.c
refinement/          where its grid lines lie, and where its error is measured
corrections.py       beside the friction terms: for growing amplitudes, for other frequencies
local/               tables by contact, of several modes on one tone
model.py             Model and its file, whose content model_content.py checks; accuracy.py
cache.py             models kept on disk, by disk_cache.py, which bounds them
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
