"""Magnetic fields: fluxgates, Hall elements and magnetoresistive bridges."""
