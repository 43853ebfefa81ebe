"""The interactive stack's processes: started, watched, restarted, ended."""
