"""Proof masses, springs, dampers, electrodes and the forces between them."""
