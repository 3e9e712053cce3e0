"""The structures and forces of the report."""
