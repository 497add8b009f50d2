"""Parameters that blocks of several families share, each set declared once as a base of their classes."""
