"""The tutorial's pages, read and run command by command."""
