"""Behind the command line: mode_table.py: `slipmode modes`; command_words.py: messages."""
