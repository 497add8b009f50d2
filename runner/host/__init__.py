"""The machine that a run happens on: versions of libraries, Ctrl-C, files kept between runs."""
