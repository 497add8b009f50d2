"""Transfer functions, averages, decimators and demodulators."""
