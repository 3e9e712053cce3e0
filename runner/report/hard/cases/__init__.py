"""The hard cases, by what strains the simulation."""
