"""The subcommands behind the command line."""
