"""What the pages are drawn with: plots, numbers in words, sections."""
