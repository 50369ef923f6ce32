"""The parts of a floating turbine: hydrodynamics, drag, moorings, turbine, tower, platform."""
