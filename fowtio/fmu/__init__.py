"""The linear model as an FMU for co-simulation: description, sources, build, check, simulation."""
