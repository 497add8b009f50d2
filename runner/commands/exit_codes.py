"""Exit codes of every command."""

DONE = 0
WRONG_MODEL = 1  # the graph or study has problems, or a check of it failed
USAGE = 2  # an option is wrong or missing
FAILED = 3  # the run failed, or a file could not be read or written
INTERRUPTED = 130  # by Ctrl-C or SIGTERM
