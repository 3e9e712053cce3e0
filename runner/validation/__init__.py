"""A scene compared with full order, validate.py: `slipmode validate`."""
