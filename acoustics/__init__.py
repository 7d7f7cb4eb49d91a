"""Sound from a released power: levels, spectra and WAV files. Knows arrays and sample rates, nothing of contact."""
