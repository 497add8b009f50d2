"""Spectra of signals: densities, tones, and how good a converter they show."""
