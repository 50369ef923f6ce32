"""Frequency-domain model to state space: rational fits of radiation and excitation, assembly, balanced reduction."""
