"""Commands that hold engines against truths and against each other."""
