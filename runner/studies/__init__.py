"""Monte Carlo studies: runs, measures, ledger and result."""
