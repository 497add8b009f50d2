"""Texts that commands print: results as lines for people."""
