"""Claims on the topics, actions and services of joints."""
