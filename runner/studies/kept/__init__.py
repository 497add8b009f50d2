"""The folder and ledger of a study."""
