"""Margins of loops: crossings, figures, sensitivities, pictures."""
