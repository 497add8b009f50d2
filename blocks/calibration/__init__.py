"""Correlators, estimators, sequencers and verdicts of self-calibration and self-test."""
