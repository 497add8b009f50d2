"""Parameters that several blocks share, each set declared once as a base of their classes."""
