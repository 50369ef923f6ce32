"""Sea and wind: dispersion, spectra, particle kinematics, turbulence over the rotor."""
