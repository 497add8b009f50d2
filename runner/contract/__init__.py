"""Tests of the contract that every block keeps: of the library's own and of a user's."""
