"""How recordings are laid out for viewers, beside what is drawn.

Start with reading.py, what each view shows; readable.py writes quantities with a prefix to their
unit, shown_units.py takes them to the scene's, stretches.py finds the windows of fast motion;
foxglove.py is a layout for Foxglove.
"""
