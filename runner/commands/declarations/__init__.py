"""Arguments and options of the commands, by subject; commands are imported when called."""
