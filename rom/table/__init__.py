"""Friction tables: S_j = Q_j |a_j| over the amplitude plane, and the model that holds them."""
