"""Arguments and options of the commands, by subject; what a command does is imported when it is called."""
