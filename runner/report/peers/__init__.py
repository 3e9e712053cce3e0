"""What slipmode is compared with, each in the strongest form at hand."""
