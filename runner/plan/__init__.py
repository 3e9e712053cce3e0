"""What a scene needs modelled, and why, before anything is computed for it."""
