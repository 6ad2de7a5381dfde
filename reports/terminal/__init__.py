"""What a person at a terminal reads and answers: colours, progress, questions, exit codes, plots in characters."""
