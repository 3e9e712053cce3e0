"""What the report measures of each method: signals, steady states, friction, cost."""
