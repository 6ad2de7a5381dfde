"""The pages of the studies; what they show is measured in reports/studies."""
